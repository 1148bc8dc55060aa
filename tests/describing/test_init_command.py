"""`deltactl init`: what it writes passes the checks it will be held to, and runs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.describing.first_job import write_first_job
from deltactl.firmware_py.describing.robot_text import robot_text
from deltactl.firmware_py.program.totals import check_job
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.robot_files import load_robot_model
from tests.describing.conftest import DELTA, WIRED, Deltactl, options


@pytest.mark.study
def test_from_options_to_a_simulated_job(deltactl: Deltactl, tmp_path: Path) -> None:
    shown = deltactl("init", "delta", "mine.yaml", *options(DELTA)).stdout
    assert "next: deltactl check mine-circle.yaml\nthen: deltactl run mine-circle.yaml" in shown
    result = json.loads(deltactl("run", "mine-circle.yaml", "--simulate", "--json").stdout)
    assert result["outcome"] == "done"
    assert load_robot(tmp_path / "mine.yaml").left_open()


def test_interchanged_arms_are_refused_and_leave_no_file(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    arms = {"upper_arm_mm": DELTA["forearm_mm"], "forearm_mm": DELTA["upper_arm_mm"]}
    refused = deltactl("init", "delta", "mine.yaml", *options(DELTA | arms), status=2)
    assert "interchanged? Nothing was written" in refused.stderr
    assert not list(tmp_path.iterdir())


def test_one_answer_about_hardware_asks_for_all(deltactl: Deltactl) -> None:
    said = deltactl(
        "init", "delta", "m.yaml", *options(DELTA), "--estop-pin", "26", status=2
    ).stderr
    assert "--step-pins is missing" in said
    assert "--home-deg is missing" in said


def test_an_answer_to_what_is_not_asked_is_refused(deltactl: Deltactl) -> None:
    said = deltactl("init", "axis", "m.yaml", "--gear-ratio", "5", status=2).stderr
    assert "--gear-ratio: a servo_axis has" in said
    said = deltactl("init", "sensor", "m.yaml", "--gear-ratio", "5", status=2).stderr
    assert "No such option: --gear-ratio" in said


def test_with_its_wiring_nothing_is_left_open(deltactl: Deltactl, tmp_path: Path) -> None:
    deltactl("init", "delta", "mine.yaml", "--wiring", *options(DELTA | WIRED))
    robot = load_robot(tmp_path / "mine.yaml")
    assert robot.left_open() == []
    assert robot.steps.alarm_pins is None
    assert robot.limits.arm_deg == (-10.0, 90.0)


@pytest.mark.study
def test_without_sensors_nothing_is_asked_of_their_pins(deltactl: Deltactl, tmp_path: Path) -> None:
    """Nor are pins kept for them: the drives may have those that sensors usually take."""
    said = {key: text for key, text in (DELTA | WIRED).items() if key != "xshut_pins"}
    pins = {"sensors": "none", "step_pins": "4 20 21", "direction_pins": "2 3 24"}
    deltactl("init", "delta", "mine.yaml", "--wiring", *options(said | pins))
    assert "xshut" not in (tmp_path / "mine.yaml").read_text()
    assert load_robot(tmp_path / "mine.yaml").left_open() == []
    assert "XSHUT" not in deltactl("service", "install", "--robot", "mine.yaml").stdout


def test_all_that_is_missing_is_said_at_once(deltactl: Deltactl) -> None:
    refused = deltactl("init", "delta", "mine.yaml", "--gear-ratio", "5", status=2)
    said = refused.stderr.splitlines()
    assert [line.split()[1] for line in said] == [
        "--base-radius-mm", "--platform-radius-mm", "--upper-arm-mm", "--forearm-mm",
        "--microsteps-per-rev",
    ]  # fmt: skip


def test_a_refused_answer_leaves_no_file(deltactl: Deltactl, tmp_path: Path) -> None:
    wrong = DELTA | {"upper_arm_mm": "150000", "gear_ratio": "-1"}
    refused = deltactl("init", "delta", "mine.yaml", *options(wrong), status=2)
    assert "--upper-arm-mm '150000': must not be above 9999" in refused.stderr
    assert "--gear-ratio '-1': must not be below 1" in refused.stderr
    wrong = DELTA | {"microsteps_per_rev": "1600.5"}
    refused = deltactl("init", "delta", "mine.yaml", *options(wrong), status=2)
    assert "--microsteps-per-rev '1600.5'" in refused.stderr
    assert not list(tmp_path.glob("*.yaml"))


def test_a_file_is_written_over_only_with_force(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("precious")
    refused = deltactl("init", "sensor", "mine.yaml", status=2)
    assert "--force" in refused.stderr
    assert (tmp_path / "mine.yaml").read_text() == "precious"
    deltactl("init", "sensor", "mine.yaml", "--force")
    assert load_robot_model(tmp_path / "mine.yaml").kind == "range_sensor"


@pytest.mark.parametrize(
    ("said", "pulses"), [("32x2", 64), ("32 x 1", 32), ("200*16", 3200), ("1600", 1600)]
)
def test_a_motor_may_have_few_full_steps_where_that_is_said(
    deltactl: Deltactl, tmp_path: Path, said: str, pulses: int
) -> None:
    """A geared tin-can motor has 32; its file was taken, but not written."""
    asked = DELTA | {"microsteps_per_rev": said, "gear_ratio": "63.68"}
    shown = deltactl("init", "delta", "m.yaml", *options(asked)).stdout
    assert load_robot(tmp_path / "m.yaml").drive.microsteps_per_rev == pulses
    assert "look here" not in shown
    read = f"--microsteps-per-rev: {said} is read as {pulses} pulses for one turn"
    assert (read in shown) is (said != "1600")
    refused = deltactl(
        "init", "delta", "n.yaml", *options(asked | {"microsteps_per_rev": "0x2"}), status=2
    )
    assert "0x2" in refused.stderr


@pytest.mark.parametrize("said", ["4:1", "1:4", "1 : 4"])
def test_a_reduction_is_read_either_way_round(
    deltactl: Deltactl, tmp_path: Path, said: str
) -> None:
    shown = deltactl("init", "delta", "m.yaml", *options(DELTA | {"gear_ratio": said})).stdout
    assert f"{said} is read as 4: the motor turns 4 times for one turn of what it drives" in shown
    assert load_robot(tmp_path / "m.yaml").drive.gear_ratio == 4.0


def test_an_arm_geared_up_is_refused_in_its_file_too(deltactl: Deltactl, tmp_path: Path) -> None:
    deltactl("init", "delta", "m.yaml", *options(DELTA))
    file = tmp_path / "m.yaml"
    file.write_text(file.read_text().replace("gear_ratio: 5", "gear_ratio: 0.25"))
    refused = deltactl("check", "m-circle.yaml", status=2).stderr
    assert "drive.gear_ratio: 0.25: did you mean 4?" in refused


@pytest.mark.study
@given(
    base=st.floats(20, 400), platform=st.floats(10, 200),
    upper=st.floats(30, 500), longer=st.floats(1.3, 3.0), gear=st.floats(1, 50),
)  # fmt: skip
@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_the_first_job_of_any_delta_may_run(
    tmp_path: Path, base: float, platform: float, upper: float, longer: float, gear: float
) -> None:
    answers = DELTA | {
        "base_radius_mm": f"{base:.1f}", "platform_radius_mm": f"{platform:.1f}",
        "upper_arm_mm": f"{upper:.1f}", "forearm_mm": f"{longer * upper:.1f}",
        "gear_ratio": f"{gear:.2f}",
    }  # fmt: skip
    file, job = tmp_path / "any.yaml", tmp_path / "any-circle.yaml"
    file.write_text(robot_text("delta", answers, wired=False))
    job.unlink(missing_ok=True)  # of the example before
    if write_first_job(load_robot(file), file, job) is None:
        assert not job.exists()
    else:
        assert check_job(job).duration_s > 0.0


@pytest.mark.study
def test_a_delta_without_sensors_says_none_and_its_first_job_runs(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    done = deltactl(
        "init", "delta", "bare.yaml", "--base-radius-mm", "120", "--platform-radius-mm", "40",
        "--upper-arm-mm", "150", "--forearm-mm", "320", "--gear-ratio", "5", "--sensors", "none",
    )  # fmt: skip
    assert load_robot(tmp_path / "bare.yaml").sensors is None
    assert "then: deltactl run bare-circle.yaml\n" in done.stdout
    assert "--accept-unseen" not in done.stdout
    deltactl("run", "bare-circle.yaml", "--simulate")


def test_how_to_home_without_sensors_is_said_of_a_wired_robot(deltactl: Deltactl) -> None:
    answers = DELTA | WIRED | {"sensors": "none"}
    said = deltactl("init", "delta", "bare.yaml", "--wiring", *options(answers)).stdout
    assert "deltactl home --accept-unseen" in said


def test_no_diagnosis_is_promised_where_nothing_is_observed(deltactl: Deltactl) -> None:
    """The command cannot work on this robot's own recordings; what would make it is said."""
    bare = deltactl("init", "delta", "bare.yaml", *options(DELTA | {"sensors": "none"})).stdout
    assert "deltactl diagnose" not in bare
    assert "columns theta_1..3" in bare
    seen = deltactl("init", "delta", "seen.yaml", *options(DELTA)).stdout
    assert "then: deltactl diagnose RECORDING --robot seen.yaml" in seen


def test_arms_in_cm_are_told_what_to_write_and_leave_no_file(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    lengths = {"base_radius_mm": "95", "platform_radius_mm": "35", "upper_arm_mm": "11"}
    wrong = DELTA | lengths | {"forearm_mm": "26"}
    (line,) = deltactl("init", "delta", "cm.yaml", *options(wrong), status=2).stderr.splitlines()
    assert "11 + 26 mm of the arm are less than the 60 mm between" in line
    assert "in cm? Then write 110 and 260. Nothing was written" in line
    assert not list(tmp_path.iterdir())
