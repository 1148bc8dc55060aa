"""A heading that says its unit wins or objects; ranges that no joint has are refused or told."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.diagnosis.admission.admit import admit
from deltactl.diagnosis.admission.doubts import far_for_a_joint
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import ServoAxis
from deltactl.models.robot_files import load_robot_model
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.names import unit_said
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.flat import from_columns
from tests.rigs.owners_words import owner_says

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
CONFIG = Path(__file__).parents[2] / "config"
T_S = 0.02 * np.arange(600)
WAVE = np.sin(0.7 * T_S) + 0.2 * np.sin(1.9 * T_S)
TURNING = ServoAxis(kind="servo_axis", name="a", motion="rotary")


def write(path: Path, heading: str, *columns: np.ndarray) -> Path:
    np.savetxt(path, np.stack(columns, axis=1), "%.6g", ",", header=heading, comments="")
    return path


@pytest.mark.parametrize(
    ("heading", "name", "unit"),
    [
        ("actual_q_deg", "position", "deg"),
        ("angle [deg]", "theta_2", "deg"),
        ("x_mm", "pos_x", "mm"),
        ("time_ms", "t", "ms"),
        ("actual_qd_deg", "velocity", "deg/s"),
        ("qd_rad_s", "velocity", "rad/s"),
        ("v_mm_per_s", "velocity", "mm/s"),
        ("motor_mA", "effort", "mA"),
        ("pos_s", "position", None),
        ("x_deg", "distance", None),
        ("position", "position", None),
    ],
)
def test_what_a_heading_says_of_its_column(heading: str, name: str, unit: str | None) -> None:
    assert unit_said(heading, name) == unit


def test_a_heading_with_its_unit_at_the_end_is_read_in_it(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "t,q_deg,qd_deg", T_S, 40.0 * WAVE, 40.0 * WAVE)
    told: list[str] = []
    options = ["position=q_deg", "velocity=qd_deg"]
    read = read_mapped(path, load_mapping(None, options), told.append)
    for name in ("position", "velocity"):
        np.testing.assert_allclose(read.column(name), np.radians(40.0 * WAVE), rtol=1e-5)
    assert "position is read in deg, as the heading 'q_deg' says" in told[0]
    assert "velocity is read in deg/s" in told[1]


@pytest.mark.parametrize(
    ("heading", "option", "instead"),
    [
        ("q_deg", "position=q_deg[rad]", "position=q_deg[deg]"),
        ("q [rad]", "position=q[deg]", "position=q[rad]"),
        ("x_mm", "position=x_mm[m]", "position=x_mm[mm]"),
        ("x_m", "position=x_m[mm]", "position=x_m[m]"),
        ("x_mm", "position=x_mm[deg]", "position=x_mm[mm]"),
    ],
)
def test_a_unit_that_the_heading_denies_is_refused(
    tmp_path: Path, heading: str, option: str, instead: str
) -> None:
    path = write(tmp_path / "a.csv", f"t,{heading}", T_S, WAVE)
    for look in (lambda said: read_mapped(path, said), lambda said: inspect(path, said)):
        with pytest.raises(RecordingError, match="the heading") as caught:
            look(load_mapping(None, [option]))
        assert f'--set "{instead}"' in str(caught.value)
    read = read_mapped(path, load_mapping(None, [f"{option}*1"]))  # as the message says
    assert np.ptp(read.column("position")) > 0.0


def test_a_letter_at_the_end_that_may_be_no_unit_does_not_object(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "t,theta_m", T_S, 40.0 * WAVE)
    read = read_mapped(path, load_mapping(None, ["position=theta_m[deg]"]))
    np.testing.assert_allclose(read.column("position"), np.radians(40.0 * WAVE), rtol=1e-5)


def test_a_wrong_heading_that_was_overruled_is_read_so_by_the_command_that_is_printed(
    tmp_path: Path,
) -> None:
    path = write(tmp_path / "a.csv", "t,q_deg,soll", T_S, WAVE, WAVE)
    found = inspect(path, load_mapping(None, ["position=q_deg[rad]*1"]))
    read = read_mapped(path, load_mapping(None, owner_says(found)))
    np.testing.assert_allclose(read.column("position"), WAVE, rtol=1e-5)


def test_counts_given_as_degrees_are_refused_and_said_to_be_counts(tmp_path: Path) -> None:
    counts = np.round(2048.0 + 500.0 * WAVE)
    path = write(tmp_path / "a.csv", "t,goal,present", T_S, counts, counts)
    said = load_mapping(None, ["command=goal[deg]", "position=present[deg]"])
    with pytest.raises(RecordingError, match=r"look like counts .*position=present\*0\.001534"):
        read_mapped(path, said)
    assert any("look like counts" in warning for warning in inspect(path, said).warnings)
    read = read_mapped(path, load_mapping(None, ["position=present[deg]*1"]))
    np.testing.assert_allclose(read.column("position"), np.radians(counts))


@pytest.mark.parametrize("readings", [np.round(90.0 * WAVE), 700.0 * WAVE])
def test_whole_degrees_of_a_joint_and_degrees_over_turns_are_read(
    tmp_path: Path, readings: np.ndarray
) -> None:
    path = write(tmp_path / "a.csv", "t,q", T_S, readings)
    told: list[str] = []
    read = read_mapped(path, load_mapping(None, ["position=q[deg]"]), told.append)
    np.testing.assert_allclose(read.column("position"), np.radians(readings), rtol=1e-5)
    assert told == []


@pytest.mark.parametrize(
    ("heading", "column", "says"),
    [
        ("timestamp,actual_q_5,actual_qd_5", "actual_q_5", "logs of RTDE are in rad"),
        ("t,q,w [rad/s]", "q", "the heading 'w [rad/s]' says rad"),
        ("t,q,w", "q", ""),
        ("t,q [deg],w [rad/s]", "q", ""),
    ],
)
def test_degrees_in_a_table_of_radians_are_doubted(
    tmp_path: Path, heading: str, column: str, says: str
) -> None:
    """Of a wrist's log in rad, read in degrees, nothing was doubted, and nonsense answered."""
    path = write(tmp_path / "a.csv", heading, T_S, 1.5 * WAVE, WAVE)
    told: list[str] = []
    sets = [f"t={heading.split(',')[0]}", f"position={column}[deg]"]
    read_mapped(path, load_mapping(None, sets), told.append)
    assert [says in one and f'"position={column}[rad]"' in one for one in told] == [True] * bool(
        says
    )


@pytest.mark.parametrize(
    ("heading", "unit", "says"),
    [
        ("t,q,goal_deg", "[rad]", "the heading 'goal_deg' says deg"),
        ("t,q,speed [deg/s]", "", "rad (or m), and the heading 'speed [deg/s]' says deg"),
        ("t,q,temp_deg", "[rad]", ""),
        ("t,q [rad],goal_deg", "", ""),
        ("t,q,goal_deg", "[deg]", ""),
    ],
)
def test_radians_in_a_table_of_degrees_are_doubted(
    tmp_path: Path, heading: str, unit: str, says: str
) -> None:
    """Of an angle typed as rad beside a command in degrees, nothing was doubted."""
    path = write(tmp_path / "a.csv", heading, T_S, 3.0 * WAVE, 3.0 * WAVE)
    told: list[str] = []
    read_mapped(path, load_mapping(None, [f"position=q{unit}"]), told.append)
    doubts = [one for one in told if "if it is in degrees" in one]
    assert [says in one and '"position=q[deg]"' in one for one in doubts] == [True] * bool(says)


@pytest.mark.study
def test_degrees_typed_as_rad_are_doubted_on_the_command_line(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    for turn in (360.0, 2.0 * np.pi):
        step = turn / 4096.0
        seen = step * np.round((8.0 * WAVE + 0.2) / step)
        write(tmp_path / "a.csv", "t,soll,q", T_S, 8.0 * WAVE, seen)
        (tmp_path / "r.yaml").write_text("kind: servo_axis\nname: a\nmotion: rotary\n")
        sets = ["--set", "position=q[rad]", "--set", "command=soll[rad]"]
        done = deltactl("diagnose", "a.csv", "--robot", "r.yaml", *sets)
        assert (done.stdout.startswith("Settle this first: position of a.csv")) == (turn == 360.0)
        assert ('--set "position=q[deg]"' in done.stderr) == (turn == 360.0)


def test_radians_over_many_turns_are_told_by_reading_and_by_the_answer(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "t,q,soll", T_S, 70.0 * WAVE, 70.0 * WAVE)
    told: list[str] = []
    read = read_mapped(
        path, load_mapping(None, ["position=q[rad]", "command=soll[rad]"]), told.append
    )
    assert 'if it is in degrees, --set "position=q[deg]"' in told[0]
    noise = 0.01 * np.random.default_rng(0).standard_normal(len(T_S))
    named = {"t": read.t_s, "command": read.column("command")}
    recording = from_columns(named | {"position": read.column("position") + noise}, "a.csv")
    (doubt,) = admit(TURNING, [recording]).doubts
    assert " turns. A motor may turn so far" in doubt.says


def test_steps_of_degrees_in_radians_are_told_by_reading_and_by_the_answer(tmp_path: Path) -> None:
    """A hobby servo's log in degrees, typed as rad: a swing of 985 degrees passed undoubted."""
    command = 8.0 * WAVE
    step = 360.0 / 4096.0
    seen = step * np.round((command + 0.2) / step)
    path = write(tmp_path / "a.csv", "t,q,soll", T_S, seen, command)
    told: list[str] = []
    named = ["t=t", "position=q[rad]", "command=soll[rad]"]
    recording = read_mapped(path, load_mapping(None, named), told.append)
    (line,) = told
    assert "in steps of 360/4096 degrees" in line
    assert 'if it is in degrees, --set "position=q[deg]"' in line
    (doubt,) = admit(TURNING, [recording]).doubts
    assert "every size below then 57 times too large" in doubt.says
    told.clear()
    named = [one.replace("rad", "deg") for one in named]
    recording = read_mapped(path, load_mapping(None, named), told.append)
    assert told == []
    assert not admit(TURNING, [recording]).doubts


def test_a_slide_and_a_joint_are_not_asked_about_turns() -> None:
    far = from_columns({"t": T_S, "command": 70.0 * WAVE, "position": 70.0 * WAVE}, "a.csv")
    near = from_columns({"t": T_S, "command": 3.0 * WAVE, "position": 3.0 * WAVE}, "a.csv")
    assert far_for_a_joint(TURNING.model_copy(update={"motion": "linear"}), far) is None
    assert far_for_a_joint(TURNING, near) is None
    assert far_for_a_joint(TURNING, far) is not None


def test_arm_angles_in_degrees_read_as_radians_are_said_to_look_like_degrees(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    names = [f"{stem}_{arm}" for stem in ("command", "theta") for arm in (1, 2, 3)]
    columns = [20.0 + 10.0 * np.sin(0.7 * T_S + int(name[-1])) for name in names]
    write(tmp_path / "run.csv", ",".join(["t", *names]), T_S, *columns)
    robot = str(CONFIG / "zhao-2023.yaml")
    said = deltactl("diagnose", "run.csv", "--robot", robot, status=2).stderr
    assert "look like degrees" in said
    assert "=COLUMN[deg]" in said
    assert "sample(s)" not in said


def test_single_arm_angles_that_went_astray_are_no_unit() -> None:
    from deltactl.diagnosis.admission.arm_columns import check_arm_angles

    theta = 0.3 * WAVE
    theta[100] = 99.0
    robot = load_robot_model(CONFIG / "zhao-2023.yaml")
    check_arm_angles(robot, from_columns({"t": T_S, "theta_1": theta}, "run.csv"))


@pytest.mark.parametrize("stems", [("command", "theta"), ("command",), ("steps", "theta")])
def test_a_deltas_table_is_not_taken_for_its_first_arm(
    deltactl: Deltactl, tmp_path: Path, stems: tuple[str, ...]
) -> None:
    names = [f"{stem}_{arm}" for stem in stems for arm in (1, 2, 3)]
    names += ["position"] if len(stems) == 1 else []
    columns = [np.round(500 * WAVE) if name.startswith("steps") else WAVE for name in names]
    write(tmp_path / "run.csv", ",".join(["t", *names]), T_S, *columns)
    robot = str(CONFIG / f"{'stepper' if 'steps' in stems else 'servo'}-axis.yaml")
    said = deltactl("diagnose", "run.csv", "--robot", robot, status=2).stderr
    assert "looks like a table of a delta" in said
    assert "deltactl init delta run-robot.yaml" in said
    assert len(said.splitlines()) == 1


@pytest.mark.study
def test_one_arm_that_somebody_chose_is_read_alone(deltactl: Deltactl, tmp_path: Path) -> None:
    names = [f"{stem}_{arm}" for stem in ("command", "theta") for arm in (1, 2, 3)]
    rng = np.random.default_rng(0)
    columns = [WAVE + 0.001 * rng.standard_normal(len(T_S)) for _ in names]
    write(tmp_path / "run.csv", ",".join(["t", *names]), T_S, *columns)
    chosen = ["--set", "command=command_2", "--set", "position=theta_2"]
    deltactl("diagnose", "run.csv", "--robot", str(CONFIG / "servo-axis.yaml"), *chosen)


def test_radians_under_a_heading_of_degrees_are_read_by_the_command_that_is_printed(
    tmp_path: Path,
) -> None:
    path = write(tmp_path / "a.csv", "t,soll [deg],ist [deg]", T_S, 40.0 * WAVE, 0.7 * WAVE)
    found = inspect(path)
    options = owner_says(found)
    assert "position=ist[rad]*1" in options
    read = read_mapped(path, load_mapping(None, options))
    np.testing.assert_allclose(read.column("position"), 0.7 * WAVE, rtol=1e-5)


def test_seconds_that_may_be_milliseconds(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "t [s],soll,ist", 1003.0 * T_S, WAVE, WAVE)
    (doubt,) = [one for one in inspect(path).warnings if "ms?" in one]
    assert doubt.startswith("t [s]: is said to be s, and one row comes every 20.06 s; ms?")
    read = read_mapped(path, load_mapping(None, ["t=t[ms]*1", "position=ist"]))
    np.testing.assert_allclose(read.t_s, 1.003 * T_S, rtol=1e-5)
