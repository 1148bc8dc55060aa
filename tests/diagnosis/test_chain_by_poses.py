"""An arm measured by a tracker: hidden zeros, lengths and yielding are found, and nothing where
nothing is hidden.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import deltactl
from benchmarks.proofs.measured_arm import (
    Hidden,
    heading,
    measured,
    oriented,
    place,
    table,
    urdf_text,
)
from deltactl.cli.main import main
from deltactl.diagnosis.answer.records import Diagnosis, ParameterResult
from deltactl.diagnosis.api import diagnose
from deltactl.foundation.errors import DeltactlError
from deltactl.recording.foreign.inspection import inspect

pytest.importorskip("mujoco")


@pytest.fixture
def arm_urdf() -> str:
    return urdf_text()


def _answer(robot: Path, hidden: Hidden, count: int = 150) -> Diagnosis:
    recorded = table(robot.parent, measured(hidden, count))
    other = table(robot.parent, measured(hidden, 80, seed=11), "other.csv")
    return diagnose([recorded], robot, [other])


def _found(answer: Diagnosis) -> set[tuple[str, str]]:
    return {(one.effect, one.component) for one in answer.findings}


def _holds(result: ParameterResult, truth: float) -> bool:
    _, low, high = result.components[0]
    return low <= truth <= high


def test_a_wrong_zero_is_found_with_its_size(robot: Path) -> None:
    hidden = Hidden()
    hidden.home_rad[2] = 0.02
    answer = _answer(robot, hidden)
    assert _found(answer) == {("home_offset", "elbow")}
    assert _holds(answer.findings[0].parameters["angle"], 0.02)
    assert answer.fit.holdout_rms_after_m < 1.2 * hidden.noise_m
    assert answer.fit.holdout_rms_before_m > 100.0 * hidden.noise_m


@pytest.mark.study
def test_a_wrong_length_is_found_at_the_joint_behind_it(robot: Path) -> None:
    hidden = Hidden()
    hidden.off[2, 2] = -0.0006
    answer = _answer(robot, hidden)
    assert _found(answer) == {("link_geometry", "elbow")}
    assert _holds(answer.findings[0].parameters["dz"], -0.0006)


@pytest.mark.study
def test_yielding_under_weight_and_a_periodic_error_are_told_apart(robot: Path) -> None:
    hidden = Hidden()
    hidden.compliance[1] = 1.5e-5
    hidden.wave_rad[2], hidden.waves[2] = 4e-4, 2
    answer = _answer(robot, hidden, 250)
    assert _found(answer) == {("joint_compliance", "shoulder"), ("transmission_error", "elbow")}
    found = {one.effect: one.parameters for one in answer.findings}
    assert _holds(found["joint_compliance"]["stiffness"], 1.0 / 1.5e-5)
    assert _holds(found["transmission_error"]["amplitude"], 4e-4)
    assert found["transmission_error"]["period"].components[0][0] == pytest.approx(np.pi, rel=0.02)


def test_nothing_is_found_where_nothing_is_hidden(robot: Path) -> None:
    answer = _answer(robot, Hidden())
    assert answer.findings == []
    assert answer.verdict == "nothing_missing"


@pytest.mark.study
def test_zeros_that_the_placement_makes_up_for_are_named(robot: Path) -> None:
    hidden = Hidden()
    hidden.home_rad[0] = 0.03
    answer = _answer(robot, hidden, 100)
    assert answer.findings == []
    assert ("home_offset", "base_pan") in {(o.effect, o.component) for o in answer.not_testable}


@pytest.mark.study
def test_what_the_robot_file_states_is_no_finding(robot: Path) -> None:
    hidden = Hidden()
    hidden.home_rad[2], hidden.off[3, 2] = 0.02, 0.001
    stated = [
        {"effect": "home_offset", "component": "elbow", "parameters": {"angle": 0.02}},
        {"effect": "link_geometry", "component": "roll", "parameters": {"dz": 0.001}},
    ]
    robot.write_text(f"{robot.read_text()}effects: {stated}\n")
    assert _answer(robot, hidden, 100).findings == []


@pytest.mark.study
def test_following_errors_and_an_arm_not_yet_at_rest_are_told_apart(robot: Path) -> None:
    hidden = Hidden(ahead_rad=5e-4, missing=0.001)
    hidden.windup[1] = 0.7
    answer = _answer(robot, hidden)
    assert _found(answer) == {("drive_windup", "shoulder"), ("sensor_latency", "sensors")}
    found = {one.effect: one.parameters for one in answer.findings}
    assert _holds(found["drive_windup"]["share"], 0.7)
    assert _holds(found["sensor_latency"]["share_of_last_move"], 0.001)


@pytest.mark.study
def test_two_reflectors_and_an_orientation_show_what_one_place_does_not(robot: Path) -> None:
    hidden = Hidden()
    hidden.home_rad[3], hidden.off[5, 5] = 0.004, 0.005
    head, rows = oriented(hidden)
    text = robot.read_text() + "targets: {pos1: {link: link_elbow}, pos2: {link: link_flange}}\n"
    robot.write_text(text)
    answer = diagnose([table(robot.parent, rows, head=head)], robot)
    assert _found(answer) == {("home_offset", "roll"), ("link_geometry", "flange")}
    found = {one.effect: one.parameters for one in answer.findings}
    assert _holds(found["home_offset"]["angle"], 0.004)
    assert _holds(found["link_geometry"]["rz"], 0.005)


def _refused(robot: Path, rows: np.ndarray) -> str:
    with pytest.raises(DeltactlError) as caught:
        diagnose([table(robot.parent, rows)], robot)
    text = str(caught.value)
    assert "\n" not in text
    return text


@pytest.mark.study
def test_places_in_mm_are_refused_with_the_name_to_give(robot: Path) -> None:
    rows = measured(Hidden(), 40)
    rows[:, 6:] *= 1e3
    assert "pos_x_mm" in _refused(robot, rows)
    recorded = table(robot.parent, rows)
    recorded.write_text(
        recorded.read_text().replace("pos_x,pos_y,pos_z", "pos_x_mm,pos_y_mm,pos_z_mm")
    )
    assert diagnose([recorded], robot).findings == []


def test_angles_in_degrees_are_refused(robot: Path) -> None:
    rows = measured(Hidden(), 40)
    rows[:, :6] = np.rad2deg(rows[:, :6])
    assert "deg" in _refused(robot, rows)


@pytest.mark.study
def test_joints_in_another_order_are_refused(robot: Path) -> None:
    rows = measured(Hidden(), 40)
    rows[:, :6] = rows[:, [2, 0, 1, 3, 4, 5]]
    assert "joints" in _refused(robot, rows)


def test_a_missing_angle_is_refused_by_joint(robot: Path) -> None:
    recorded = table(robot.parent, measured(Hidden(), 40))
    recorded.write_text(recorded.read_text().replace("theta_4", "angle_d", 1))
    with pytest.raises(DeltactlError, match="'roll'"):
        diagnose([recorded], robot)


@pytest.mark.study
def test_poses_at_rest_are_read_beside_efforts(robot: Path) -> None:
    hidden = Hidden()
    hidden.home_rad[1] = 0.01
    rows = measured(hidden, 60)
    head = [*heading(rows), *(f"effort_{n}" for n in range(1, 7)), "segment"]
    still = np.column_stack([rows, np.ones((60, 6)), np.arange(60)])
    answer = diagnose([table(robot.parent, still, head=head)], robot)
    assert _found(answer) == {("home_offset", "shoulder")}


@pytest.mark.study
def test_a_long_motion_is_thinned_and_late_places_are_seen(robot: Path) -> None:
    t_s = np.arange(1600) / 50.0
    angles = np.stack([0.8 * np.sin((0.5 + 0.13 * j) * t_s + j) for j in range(6)], axis=1)
    late = np.stack([0.8 * np.sin((0.5 + 0.13 * j) * (t_s - 0.004) + j) for j in range(6)], axis=1)
    noise = 2e-5 * np.random.default_rng(5).standard_normal((len(t_s), 3))
    seen = np.array([place(q, Hidden())[0] for q in late]) + noise
    head = ["t", *heading(np.zeros((1, 9)))]
    rows = np.column_stack([t_s, angles, seen])
    recorded = table(robot.parent, rows, times=False, head=head)
    answer = diagnose([recorded], robot)
    assert _found(answer) == {("sensor_latency", "sensors")}
    late_s = answer.findings[0].parameters["time"].components[0][0]
    assert late_s == pytest.approx(0.004, rel=0.02)


def test_inspect_sees_a_chain_that_was_measured(robot: Path) -> None:
    seen = inspect(table(robot.parent, measured(Hidden(), 20), times=False))
    assert seen.kind == "chain"
    assert seen.guesses["theta_6"].name == "theta_6"
    assert seen.options == []


@pytest.mark.study
def test_a_table_of_poses_needs_no_times(
    robot: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    hidden = Hidden()
    hidden.home_rad[1] = 0.01
    recorded = table(robot.parent, measured(hidden, 100), times=False)
    line = ["deltactl", "diagnose", str(recorded), "--robot", str(robot)]
    monkeypatch.setattr("sys.argv", line)
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code in (0, None)
    assert "shoulder" in capsys.readouterr().out


@pytest.mark.study
def test_poses_from_python_need_no_times(robot: Path) -> None:
    hidden = Hidden()
    hidden.home_rad[2] = 0.02
    rows = measured(hidden)
    frame = pd.DataFrame(rows, columns=heading(rows))
    (found,) = deltactl.diagnose(deltactl.Recording.from_pandas(frame), robot).answer.findings
    assert (found.effect, found.component) == ("home_offset", "elbow")
