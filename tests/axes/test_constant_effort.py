"""A constant effort is found whatever its size, beside noise that is small and smaller."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose

pytest.importorskip("scipy", reason="the diagnosis needs the extra 'diagnosis'")

INERTIA = 1e-4
ROBOT = f"kind: servo_axis\nname: shaft\nmotion: rotary\ninertia: {INERTIA}\neffort_gain: 1\n"


def recorded(folder: Path, constant_nm: float, noise_nm: float, seed: int) -> list[Path]:
    """A shaft that swings at two frequencies under its inertia, a constant effort and noise.

    Its inertia needs less than the noise: nothing but the constant says how large forces are.
    """
    t_s = np.arange(0.0, 15.0, 0.01)
    swings = ((0.9, 2.1, 0.0), (0.35, 5.3, 1.0))
    angle_rad = sum(size * np.sin(rate * t_s + at) for size, rate, at in swings)
    accel = sum(-size * rate**2 * np.sin(rate * t_s + at) for size, rate, at in swings)
    noise = np.random.default_rng(seed).normal(0.0, noise_nm, len(t_s))
    effort_nm = INERTIA * accel + constant_nm + noise
    np.savetxt(
        folder / "log.csv", np.column_stack([t_s, angle_rad, effort_nm]), delimiter=",",
        header="t,position,effort", comments="", fmt="%.8g",
    )  # fmt: skip
    (folder / "robot.yaml").write_text(ROBOT)
    return [folder / "log.csv"]


@pytest.mark.study
@pytest.mark.parametrize(("constant_nm", "noise_nm"), [(0.05, 0.02), (-3.0, 0.02), (1.0, 2e-3)])
def test_it_is_found_and_nothing_is_left(
    tmp_path: Path, constant_nm: float, noise_nm: float
) -> None:
    answer = diagnose(recorded(tmp_path, constant_nm, noise_nm, 8), tmp_path / "robot.yaml")
    assert [finding.effect for finding in answer.findings] == ["effort_offset"]
    size = answer.findings[0].parameters["offset"]
    assert size.value == pytest.approx(constant_nm, abs=noise_nm / 5.0)
    assert answer.fit.rms_after_m < noise_nm
    assert answer.fit.holdout_rms_after_m < 1.2 * answer.fit.rms_after_m


@pytest.mark.study
def test_without_one_nothing_is_named(tmp_path: Path) -> None:
    answer = diagnose(recorded(tmp_path, 0.0, 0.02, 9), tmp_path / "robot.yaml")
    assert answer.findings == []
