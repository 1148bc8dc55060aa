"""`timing: {t_pwm_s: 0.006}` is enough: together is the mode of the paper and the default."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.job_file import Accelerated, JobFile, Together
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.strict_yaml import Document

JOB = """\
name: test
robot: zhao-2023.yaml
path: {shape: circle, centre_m: [0, 0, -0.4], radius_m: 0.05}
inverse_kinematics: {kind: geometry}
timing: """


def job(timing: str) -> JobFile:
    return Document(Path("job.yaml"), JOB + timing + "\n").check(JobFile)


def test_together_unless_told_otherwise() -> None:
    assert job("{t_pwm_s: 0.006}").timing == Together(t_pwm_s=0.006)
    assert job("{mode: together, t_pwm_s: 5e-5}").timing == Together(t_pwm_s=5e-5)
    accelerated = job("{mode: accelerated, speed_mps: 0.1}").timing
    assert accelerated == Accelerated(mode="accelerated", speed_mps=0.1)


def test_a_job_written_out_is_the_same_job() -> None:
    plan = job("{t_pwm_s: 0.006}")
    assert JobFile.model_validate_json(plan.model_dump_json()) == plan


@pytest.mark.parametrize(
    ("timing", "message"),
    [
        ("{}", "timing: 't_pwm_s' is missing"),
        ("{t_pmw_s: 1}", "timing.t_pmw_s: unknown key; did you mean 't_pwm_s'?"),
        ("{speed_mps: 1}", "timing.speed_mps: unknown key here; it belongs to mode accelerated"),
        ("{mode: fast}", "timing.mode: must be one of together, accelerated (got 'fast')"),
        ("{mode: }", "timing: 'mode' is empty"),
        (
            "{mode: accelerated, speed_mps: x}",
            "timing.speed_mps: Input should be a valid number (got 'x')",
        ),
        (
            "{t_pwm_s: 1e-5}",
            "timing.t_pwm_s: Input should be greater than or equal to 0.00005 (got 1e-05)"
            ": the pulse process is good for 50 us and up",
        ),
        ("5", "timing: Input should be an object (got 5)"),
        ("", "timing: Input should be an object (got None)"),
    ],
)
def test_mistakes_in_the_timing(timing: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        job(timing)
    assert str(caught.value) == f"job.yaml:5: {message}"
