"""The robot moved from rest to rest is the robot that is simulated in time."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the as-built robot needs the extra 'proof'")

from deltactl.firmware_py.collecting.survey import survey_counts
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import ConfigError, UnreachablePoint
from deltactl.models.linkage import Linkage, forward
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import together
from deltactl.proof.robot.run import run
from deltactl.reproduction.zhao_2023.as_built import AS_BUILT_FILE, load_as_built, machine_of
from deltactl.reproduction.zhao_2023.settling import ExpectedMap, SettlingRobot

START = np.array([1333, 1333, 1333])
ROBOT = load_robot(find("zhao-2023.yaml"))


@pytest.fixture(scope="module")
def machine() -> Machine:
    return machine_of(load_as_built(AS_BUILT_FILE, ROBOT), ROBOT)


@pytest.mark.study
def test_it_rests_where_the_robot_in_time_rests(machine: Machine) -> None:
    targets = survey_counts(ROBOT, 12, seed=5)
    settling = SettlingRobot(machine.robot, START)
    rests_m = np.array([settling.move(counts) for counts in targets])
    train = together(START, targets, np.full(len(targets), 0.5), 0.002)
    truth = run(machine.robot, train)
    moved = np.abs(np.diff(np.vstack([START[None], targets]), axis=0)).max(axis=1)
    ends_s = (np.cumsum(moved + 250) - 3) * 0.002
    true_m = truth.position_m[np.searchsorted(truth.t_s, ends_s)]
    apart_m = np.linalg.norm(true_m - rests_m, axis=1)
    # Play is up to 1.1 mm at the platform and noise 0.6 mm: most rests agree far better, and
    # none is off by more than an arm on its other flank.
    assert np.median(apart_m) < 0.25e-3
    assert apart_m.max() < 1.5e-3


def test_where_it_came_from_matters(machine: Machine) -> None:
    """Friction and play are history: the same counts from above and from below differ."""
    rests_m = []
    for first in (START - 300, START + 300):
        settling = SettlingRobot(machine.robot, first)
        rests_m.append(settling.move(START))
    assert 1e-5 < np.linalg.norm(rests_m[0] - rests_m[1]) < 2e-3


def test_a_restored_robot_goes_on_exactly(machine: Machine) -> None:
    targets = survey_counts(ROBOT, 6, seed=3)
    settling = SettlingRobot(machine.robot, START)
    for counts in targets[:3]:
        settling.move(counts)
    state = settling.state()
    wanted_m = [settling.move(counts) for counts in targets[3:]]
    other = SettlingRobot(machine.robot, START)
    other.restore(state)
    assert np.array_equal([other.move(counts) for counts in targets[3:]], wanted_m)


@pytest.mark.study
def test_it_never_folds_through(machine: Machine) -> None:
    """Every pose is the one below the elbows, near where shifted rigid arms would put it."""
    targets = survey_counts(ROBOT, 150, seed=1)
    settling = SettlingRobot(machine.robot, START)
    rests_m = np.array([settling.move(counts) for counts in targets])
    homes = np.radians([11.0, 14.0, 12.0])
    linkage = Linkage.of(ROBOT.geometry).with_(home_offset_rad=homes)
    rigid_m = forward(linkage, targets * ROBOT.drive.rad_per_step).position_m
    assert np.linalg.norm(rests_m - rigid_m, axis=1).max() < 0.03


def test_a_jam_leaves_it_where_it_was(machine: Machine) -> None:
    settling = SettlingRobot(machine.robot, START)
    before_m = settling.position_m
    flat = np.round(np.radians([-12.0, -14.0, -12.0]) / ROBOT.drive.rad_per_step).astype(int)
    with pytest.raises(UnreachablePoint, match="jams"):
        settling.move(flat)
    assert np.array_equal(settling.position_m, before_m)


def test_the_expected_map_is_turned_round(machine: Machine) -> None:
    assert ROBOT.sensors is not None
    expected = ExpectedMap(machine, ROBOT.sensors)
    target_m = np.array([[0.05, -0.03, -0.5], [0.06, -0.03, -0.5]])
    counts = expected.counts_of(target_m, np.array([1700, 1700, 1700]))
    settling = SettlingRobot(expected._robot, counts[0])
    seen_m = expected.measured_m(np.array([settling.position_m, settling.move(counts[1])]))
    assert np.abs(seen_m - target_m).max() < 1.5e-4  # half a microstep moves 0.05 mm an arm


def test_an_as_built_file_of_another_robot_is_refused() -> None:
    other = load_robot(find("zhao-2023-as-printed.yaml"))
    with pytest.raises(ConfigError, match="is about robot"):
        load_as_built(AS_BUILT_FILE, other)
