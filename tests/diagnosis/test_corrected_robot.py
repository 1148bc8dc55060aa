"""The corrected robot file is a robot file: the old one, and what was found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.answer.corrected_robot import corrected_text, save_corrected
from deltactl.diagnosis.answer.records import (
    Alternative,
    Diagnosis,
    Evidence,
    Finding,
    Fit,
    ParameterResult,
    Unexplained,
    Where,
)
from deltactl.foundation.errors import RecordingError
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import DeltaRobot
from deltactl.models.robot_files import load_delta

ROBOT = """# a comment worth keeping
kind: delta
name: little
geometry: {base_radius_m: 0.3, platform_radius_m: 0.1, upper_arm_m: 0.25, forearm_m: 0.5}
"""


def finding(effect: str, component: str, **values: float | list[float]) -> Finding:
    parameters = {
        name: ParameterResult(value=value, ci95=[0.0, 1.0], unit="")
        for name, value in values.items()
    }
    return Finding(
        effect=effect,
        component=component,
        says="",
        parameters=parameters,
        where=Where(axes=[], times_s=[], regime=""),
        evidence=Evidence(delta_chi2=1.0, p=0.0),
        share_of_mismatch=1.0,
    )


def answer(*findings: Finding) -> Diagnosis:
    fit = Fit(
        rms_before_m=1.0,
        rms_after_m=1.0,
        noise_floor_m=1.0,
        holdout_rms_before_m=1.0,
        holdout_rms_after_m=1.0,
    )
    nothing = Unexplained(share_of_mismatch=0.0, depends_on=[], says="")
    return Diagnosis(
        verdict="explained",
        false_alarm_p=0.0,
        fit=fit,
        findings=list(findings),
        unexplained=nothing,
        recordings=["runs/survey.mcap"],
    )


@pytest.fixture
def robot_file(tmp_path: Path) -> Path:
    path = tmp_path / "little.yaml"
    path.write_text(ROBOT)
    return path


def test_what_lasts_is_kept_and_acts(robot_file: Path, tmp_path: Path) -> None:
    found = answer(
        finding("home_offset", "motor2", angle=0.02),
        finding("lost_steps", "motor1", steps=40.0, time=3.0),
        finding("unknown", "range_x"),
        finding("frame_tilt", "frame", rotation=[0.0, 0.0, 0.01]),
    )
    out = tmp_path / "found.yaml"
    save_corrected(robot_file, found, out)
    assert out.read_text().startswith("# a comment worth keeping")
    robot = load_delta(out)
    assert [entry.effect for entry in robot.effects] == ["home_offset", "frame_tilt"]
    angles = np.full((3, 3), 0.5)
    commands = Commands.of_angles(np.arange(3.0), angles)
    theta = Chain(robot).simulate(commands).theta
    np.testing.assert_allclose(theta[:, 1] - theta[:, 0], 0.02)


def test_a_second_diagnosis_adds_to_the_first(robot_file: Path, tmp_path: Path) -> None:
    once = tmp_path / "once.yaml"
    save_corrected(robot_file, answer(finding("home_offset", "motor2", angle=0.02)), once)
    twice = tmp_path / "twice.yaml"
    save_corrected(once, answer(finding("sensor_offset", "range_x", offset=0.01)), twice)
    robot: DeltaRobot = load_delta(twice)
    assert [entry.component for entry in robot.effects] == ["motor2", "range_x"]


def test_a_size_found_again_replaces_the_one_believed(robot_file: Path, tmp_path: Path) -> None:
    once, twice = tmp_path / "once.yaml", tmp_path / "twice.yaml"
    save_corrected(robot_file, answer(finding("home_offset", "motor2", angle=0.02)), once)
    save_corrected(once, answer(finding("home_offset", "motor2", angle=-0.003)), twice)
    (entry,) = load_delta(twice).effects
    assert entry.parameters["angle"] == pytest.approx(0.017)
    assert entry.found is not None
    assert entry.found.recordings == ("survey.mcap",)
    assert entry.found.ci95["angle"] == pytest.approx((0.02, 1.02))
    assert twice.read_text().count("effects:") == 1
    assert twice.read_text().startswith("# a comment worth keeping")


def test_what_is_not_sure_is_written_only_when_asked_for(robot_file: Path) -> None:
    tie = Alternative(effect="frame_tilt", component="frame", delta_chi2=1.0)
    tied = finding("home_offset", "motor2", angle=0.02).model_copy(update={"alternatives": [tie]})
    faint = finding("gear_ratio", "motor1", scale=1.01).model_copy(update={"probability": 0.5})
    found = answer(tied, faint)
    assert corrected_text(robot_file, found) == ROBOT
    assert corrected_text(robot_file, found, all_of_them=True).count("component") == 2


def test_rivals_that_ask_for_the_same_correction_are_no_doubt(robot_file: Path) -> None:
    play = Alternative(effect="gear_backlash", component="motor2", delta_chi2=1.0, probability=0.5)
    home = finding("home_offset", "motor2", angle=0.02)
    for probability in (None, 0.45):
        update = {"alternatives": [play], "probability": probability}
        assert "angle: 0.02" in corrected_text(robot_file, answer(home.model_copy(update=update)))


@pytest.mark.parametrize(
    ("unknown", "its_evidence", "shows_in", "rival", "held_out", "written"),
    [
        ("motor1", 0.5, "range_z", None, 0.5, True),
        ("motor1", 0.5, "range_z", "gear_ratio motor3", 0.5, True),
        ("motor1", 2.0, "range_z", None, 0.5, False),  # what is found may be a part of it
        ("range_z", 0.5, "range_z", None, 0.5, False),  # may be all there is, and moves nothing
        ("range_z", 2.0, "range_x", None, 0.5, True),  # where nothing unknown is
        ("platform", 0.5, "range_z", None, 0.5, False),
        ("motor1", 0.5, "range_z", "sensor_offset range_z", 0.5, False),
        ("motor1", 0.5, "range_z", None, 1.0, False),  # foretells nothing
    ],
)
def test_what_an_unknown_beside_it_cannot_imitate_is_corrected(
    robot_file: Path,
    unknown: str,
    its_evidence: float,
    shows_in: str,
    rival: str | None,
    held_out: float,
    written: bool,
) -> None:
    beside = finding("unknown", unknown, size_rms=0.002)
    beside.evidence.delta_chi2 = its_evidence
    beside.where.axes = ["range_z"]
    home = finding("home_offset", "motor2", angle=0.02).model_copy(update={"probability": 0.2})
    home.where.axes = [shows_in, "range_y"]
    if rival is not None:
        effect, component = rival.split()
        home.alternatives.append(
            Alternative(effect=effect, component=component, delta_chi2=1.0, probability=0.2)
        )
    found = answer(home, beside)
    found.fit.holdout_rms_after_m = held_out
    assert ("angle: 0.02" in corrected_text(robot_file, found)) == written


def test_nothing_found_changes_nothing_and_no_file_is_written_over(robot_file: Path) -> None:
    assert corrected_text(robot_file, answer()) == ROBOT
    with pytest.raises(RecordingError, match="exists already"):
        save_corrected(robot_file, answer(), robot_file)
    assert robot_file.read_text() == ROBOT
    other = robot_file.with_name("other.yaml")
    other.write_text("old")
    save_corrected(robot_file, answer(), other, replace=True)
    assert other.read_text() == ROBOT
