"""Joints of a chain whose columns are counts: the robot file's `drive` makes them angles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.proofs.measured_arm import Hidden, measured, table
from benchmarks.proofs.measured_arm import urdf_text as six_axes
from deltactl.cli.recordings.init_chain import chain
from deltactl.cli.recordings.tables import read_plain
from deltactl.diagnosis.admission.chain_columns import angles_in
from deltactl.diagnosis.answer.records import Diagnosis
from deltactl.diagnosis.api import diagnose
from deltactl.foundation.errors import ConfigError, DeltactlError, RefusedRecording
from deltactl.models.robot import ChainRobot
from deltactl.models.robot_files import load_with_effects
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from deltactl.recording.tables.chain_tables import joints_of
from deltactl.recording.tables.flat_files import read_flat
from tests.diagnosis.test_chain_of_joints import FRICTION_NM, recorded, urdf_text

pytest.importorskip("mujoco")

COUNTS, GEAR = 4096, 5.0
COUNT_RAD = 2.0 * np.pi / (COUNTS * GEAR)
COARSE_RAD = 2.0 * np.pi / COUNTS


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """An arm of three joints, of which all count."""
    (tmp_path / "arm.urdf").write_text(urdf_text())
    file = tmp_path / "arm.yaml"
    chain(file, tmp_path / "arm.urdf", microsteps_per_rev=str(COUNTS), gear_ratio=f"{GEAR:g}")
    return file


def _machine(file: Path) -> ChainRobot:
    found = load_with_effects(file)
    assert isinstance(found, ChainRobot)
    return found


def _cells(file: Path) -> tuple[str, np.ndarray]:
    head, *rows = file.read_text().splitlines()
    return head, np.loadtxt(rows, delimiter=",")


def _counted(file: Path, joints: slice = slice(1, 4)) -> Path:
    """The same table with angles as counts, and speeds as counts a second."""
    head, cells = _cells(file)
    speeds = np.gradient(cells[:, 1:4], cells[:, 0], axis=0)
    cells[:, joints] = np.rint(cells[:, joints] / COUNT_RAD)
    head += ",velocity_1,velocity_2,velocity_3"
    counted = file.with_name("counts.csv")
    rows = np.column_stack([cells, speeds / COUNT_RAD])
    np.savetxt(counted, rows, "%.9g", ",", header=head, comments="")
    return counted


def test_counts_are_angles_within_half_a_count(robot: Path) -> None:
    file = recorded(robot.parent)
    turned = angles_in(_machine(robot), read_flat(_counted(file)))
    joints = _machine(robot).joints
    angles, speeds = (joints_of(joints, turned, stem) for stem in ("theta", "velocity"))
    truth = _cells(file)[1]
    assert angles is not None
    assert speeds is not None
    assert np.abs(angles - truth[:, 1:4]).max() <= 0.5001 * COUNT_RAD
    np.testing.assert_allclose(speeds, np.gradient(truth[:, 1:4], truth[:, 0], axis=0), atol=1e-6)


def test_counts_begin_at_the_zero_of_the_model(robot: Path) -> None:
    file = _counted(recorded(robot.parent))
    before = angles_in(_machine(robot), read_flat(file))
    robot.write_text(f"{robot.read_text()}zero_count: [0, 2048, -100]\n")
    after = angles_in(_machine(robot), read_flat(file))
    for stem, moved in (("theta", np.array([0.0, -2048.0, 100.0])), ("velocity", np.zeros(3))):
        earlier, later = (joints_of(_machine(robot).joints, one, stem) for one in (before, after))
        assert earlier is not None
        assert later is not None
        np.testing.assert_allclose(later - earlier, np.tile(moved * COUNT_RAD, (len(later), 1)))


def test_friction_is_found_by_counts_with_its_size(robot: Path) -> None:
    (found,) = diagnose([_counted(recorded(robot.parent, FRICTION_NM))], robot).findings
    assert (found.effect, found.component) == ("joint_friction", "shoulder")
    _, low, high = found.parameters["torque"].components[0]
    assert low <= FRICTION_NM <= high


def test_a_joint_without_a_drive_and_a_column_with_a_unit_stay_angles(robot: Path) -> None:
    drive = f"{{microsteps_per_rev: {COUNTS}, gear_ratio: {GEAR:g}}}"
    kept = robot.read_text().split("drive:")[0]
    robot.write_text(f"{kept}drive: [null, {drive}, {drive}]\n")
    file = _counted(recorded(robot.parent), slice(2, 3))
    mapping = load_mapping(None, ["theta_3=theta_3[rad]", "velocity_3=velocity_3[rad/s]"])
    read = read_mapped(file, mapping)
    turned = angles_in(_machine(robot), read)
    before, after = (joints_of(("a", "b", "c"), one, "theta") for one in (read, turned))
    assert before is not None
    assert after is not None
    np.testing.assert_allclose(after, before * np.array([1.0, COUNT_RAD, 1.0]))


def test_angles_that_a_drive_calls_counts_are_refused(robot: Path) -> None:
    with pytest.raises(RefusedRecording) as caught:
        diagnose([recorded(robot.parent)], robot)
    assert "theta_1" in str(caught.value)
    assert '--set "theta_1=theta_1[rad]"' in str(caught.value)


def test_counts_without_a_drive_are_refused_with_the_key(robot: Path) -> None:
    counted = _counted(recorded(robot.parent))
    robot.write_text(robot.read_text().split("drive:")[0])
    with pytest.raises(RefusedRecording, match="`drive`"):
        diagnose([counted], robot)


@pytest.mark.parametrize(
    ("drive", "says"),
    [
        ("{counts_per_rev: 4096, gear_ratio: 5}", "did you mean 'microsteps_per_rev'?"),
        ("[{microstep_per_rev: 9, gear_ratio: 5}, null, null]", "'microsteps_per_rev'?"),
        ("[{microsteps_per_rev: 4096}, null, null]", "drive.0: 'gear_ratio' is missing"),
        ("[{microsteps_per_rev: 4096, gear_ratio: 0}, null, null]", "motor turns per arm turn"),
    ],
)
def test_a_wrong_drive_is_refused_by_line(robot: Path, drive: str, says: str) -> None:
    kept = robot.read_text().split("drive:")[0]
    robot.write_text(f"{kept}drive: {drive}\n")
    line = len(kept.splitlines()) + 1
    with pytest.raises(ConfigError) as caught:
        load_with_effects(robot)
    assert f"{robot}:{line}: " in str(caught.value)
    assert says in str(caught.value)


def test_drives_are_one_or_one_a_joint(robot: Path) -> None:
    robot.write_text(f"{robot.read_text().split('drive:')[0]}drive: [null]\n")
    with pytest.raises(ConfigError, match="drive has 1 entries and joints 3 names"):
        load_with_effects(robot)


def test_a_slide_has_no_drive(robot: Path) -> None:
    model = robot.with_name("arm.urdf")
    model.write_text(model.read_text().replace("revolute", "prismatic", 1))
    with pytest.raises(ConfigError, match="joint 'waist' slides"):
        diagnose([_counted(recorded(robot.parent))], robot)


def test_init_writes_drives_and_commands_in_counts(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf_text())
    model = tmp_path / "arm.urdf"
    file = tmp_path / "mixed.yaml"
    chain(file, model, microsteps_per_rev="200x16,none,4096", gear_ratio="5:1,1,1", poses=15)
    assert _machine(file).rad_per_count == (
        pytest.approx(2.0 * np.pi / 16000.0), None, pytest.approx(COARSE_RAD)
    )  # fmt: skip
    commands = _cells(file.with_name("mixed-poses.csv"))[1]
    assert np.array_equal(commands[:, [0, 2]], np.rint(commands[:, [0, 2]]))
    assert np.abs(commands[:, 1]).max() <= 3.0 < np.abs(commands[:, 2]).max()


def test_init_writes_the_zero_and_commands_around_it(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf_text())
    file = tmp_path / "servos.yaml"
    chain(
        file, tmp_path / "arm.urdf", microsteps_per_rev="4096", zero_count="2048,2048,0", poses=15
    )
    assert _machine(file).zero_counts == (2048, 2048, 0)
    middle = _cells(file.with_name("servos-poses.csv"))[1].mean(axis=0)
    assert np.array_equal(np.abs(middle - np.array([2048, 2048, 0])) < 1024, [True] * 3)
    with pytest.raises(ConfigError, match="--microsteps-per-rev"):
        chain(tmp_path / "other.yaml", tmp_path / "arm.urdf", zero_count="2048")


@pytest.mark.parametrize(
    ("steps", "gear", "says"),
    [
        (None, "50", "--gear-ratio is given with"),
        ("4096,4096", "5", "2 numbers for the joints waist, shoulder, elbow"),
        ("8", "5", "8 microsteps a full step"),
    ],
)
def test_init_refuses_what_is_no_drive(
    tmp_path: Path, steps: str | None, gear: str | None, says: str
) -> None:
    (tmp_path / "arm.urdf").write_text(urdf_text())
    with pytest.raises(DeltactlError, match=says):
        chain(tmp_path / "a.yaml", tmp_path / "arm.urdf", microsteps_per_rev=steps, gear_ratio=gear)


def _by_coarse_counts(folder: Path, home_rad: float) -> Diagnosis:
    """Poses of an arm whose encoders have 4096 counts a turn, and no gear: up to 0.8 mm at 1 m."""
    (folder / "six.urdf").write_text(six_axes())
    robot, hidden = folder / "six.yaml", Hidden()
    chain(robot, folder / "six.urdf", microsteps_per_rev=str(COUNTS), gear_ratio="1")
    hidden.home_rad[2] = home_rad
    rows = measured(hidden, 150, seed=4)
    rows[:, :6] = np.rint(rows[:, :6] / COARSE_RAD)
    machine = _machine(robot)
    file = table(folder, rows, times=False)
    return diagnose([file], robot, read=lambda path: read_plain(path, machine))


def test_rounding_of_coarse_counts_is_no_finding(tmp_path: Path) -> None:
    answer = _by_coarse_counts(tmp_path, 0.0)
    assert answer.findings == []
    assert answer.verdict == "nothing_missing"


@pytest.mark.study
def test_a_zero_is_found_beside_rounding(tmp_path: Path) -> None:
    (found,) = _by_coarse_counts(tmp_path, 0.004).findings
    assert (found.effect, found.component) == ("home_offset", "elbow")
    _, low, high = found.parameters["angle"].components[0]
    assert low <= 0.004 <= high
