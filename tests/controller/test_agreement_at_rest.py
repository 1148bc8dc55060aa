"""Where the ranges and the counts part: at home, at rest, at a job's end; and sensors that lie."""

from __future__ import annotations

import re
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.drivers.fakes.vl53l1x_scene import ChipFaults
from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.sensing.cause import causes
from deltactl.firmware_py.controller.sensing.determined import range_slopes_m
from deltactl.firmware_py.controller.sensing.home_check import check_plausible, expected_ranges_m
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import NotReady
from deltactl.models.linkage import Linkage, forward

ROBOT = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
TURNED_DEG = 0.0225
"""Of an arm, by a step."""


def faults_of(controller: Controller, axis: str) -> ChipFaults:
    assert controller.machine.rig is not None
    return controller.machine.rig.chips[axis].faults


def sag(controller: Controller, motor: int, steps: int, each_s: float) -> int:
    """A drive lets an arm go step by step; how many it takes until the robot is not homed."""
    assert controller.machine.bench is not None
    for taken in range(abs(steps)):
        if controller.status().state != "ready":
            return taken
        controller.machine.bench.slip(motor, int(np.sign(steps)))
        sleep_s(controller.clock, each_s)
    return abs(steps)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1, 1])
def test_home_is_refused_from_the_tolerance_on_and_warned_of_from_the_other(
    axis: int, sign: int
) -> None:
    """On both sides: a tolerance that is doubled, or kept on one side only, is seen."""
    expected_m = expected_ranges_m(ROBOT)
    assert expected_m is not None
    off = sign * np.eye(3)[axis]
    tolerance_m, warning_m = ROBOT.homing.tolerance_m, ROBOT.homing.warning_m
    with pytest.raises(NotReady, match=f"sensor {'xyz'[axis]}"):
        check_plausible(ROBOT, expected_m + 1.05 * tolerance_m * off)
    assert check_plausible(ROBOT, expected_m + 0.95 * tolerance_m * off).warning
    assert check_plausible(ROBOT, expected_m + 1.05 * warning_m * off).warning
    assert not check_plausible(ROBOT, expected_m + 0.95 * warning_m * off).warning


@pytest.mark.parametrize(("motor", "direction"), [(1, -1), (2, 1)])
def test_an_arm_that_sags_slowly_is_noticed(homed: Controller, motor: int, direction: int) -> None:
    """At 1.4 mm/s of the elbow, to either side; 10 mm of a range are three degrees of an arm."""
    sleep_s(homed.clock, 3.0)
    taken = sag(homed, motor, direction * 524, 0.07)
    assert homed.status().state == "unhomed"
    assert f"motor{motor}" in homed.status().why
    assert taken * TURNED_DEG < 5.0


def test_less_than_the_limit_is_left_alone(homed: Controller) -> None:
    """40 steps, 0.9 degrees, 3.3 mm of the range that sees most of it."""
    sleep_s(homed.clock, 3.0)
    sag(homed, 1, -40, 0.07)
    sleep_s(homed.clock, 5.0)
    assert homed.status().state == "ready"


def test_a_job_asked_for_after_an_arm_sagged_does_not_run(homed: Controller, write_job) -> None:
    sleep_s(homed.clock, 3.0)
    job = write_job()
    sag(homed, 2, -524, 0.07)
    with pytest.raises(NotReady, match="unhomed"):
        homed.submit(job)


@pytest.mark.study
@pytest.mark.parametrize(
    ("steps", "t_pwm_s", "outcome"), [(110, 0.012, "fault"), (20, 0.006, "done")]
)
def test_what_crept_in_during_a_job_is_seen_at_its_end(
    tmp_path: Path, write_job, steps: int, t_pwm_s: float, outcome: str
) -> None:
    """Too slowly for the watch in motion: all arms sink together, by 2.5 degrees or by 0.5."""
    robot = tmp_path / "strict.yaml"
    robot.write_text((CONFIG_FOLDER / "zhao-2023.yaml").read_text() + "\n  tolerance_m: 0.012\n")
    made = build_controller(robot, simulated=True, realtime=False, recordings=tmp_path)
    with closing(made) as one:
        one.power_on()
        one.home()
        number = one.submit(write_job("long", radius_m=0.05, t_pwm_s=t_pwm_s, robot=robot))
        then = one.submit(write_job("next", robot=robot))
        assert one.machine.bench is not None
        sleep_s(one.clock, 1.0)
        sunk = 0
        while one.result(number) is None:
            if sunk < steps and one.status().state == "running":
                sunk += 1
                for motor in (1, 2, 3):
                    one.machine.bench.slip(motor, -1)
            sleep_s(one.clock, 0.1)
        assert sunk == steps
        result = one.result(number)
        assert result is not None
        assert result.outcome == outcome
        if outcome == "fault":
            assert "drive power lost" in result.why
            assert one.status().state == "fault"
            sleep_s(one.clock, 0.1)
            assert one.result(then) is not None
            assert one.result(then).outcome == "fault"


LIES: tuple[dict[str, Any], ...] = (
    {"stuck_m": 0.95},
    {"offset_m": 0.03},
    {"offset_m": -0.1},
    {"scale": 1.1},
)


@pytest.mark.parametrize(
    ("axis", "running", "lie"),
    [("x", False, LIES[0]), ("y", True, LIES[1]), ("y", True, LIES[2]), ("x", False, LIES[3])],
)
def test_a_sensor_that_lies_is_named_and_no_motor(
    homed: Controller, write_job, running: bool, axis: str, lie: dict[str, Any]
) -> None:
    if running:
        homed.submit(write_job("long", radius_m=0.06))
    sleep_s(homed.clock, 5.0)
    faults_of(homed, axis).__dict__.update(lie)
    sleep_s(homed.clock, 1.0)
    status = homed.status()
    assert status.state == ("fault" if running else "unhomed")
    assert f"sensor {axis} reads" in status.why
    assert "motor" not in status.why


def test_a_sensor_that_keeps_its_value_while_the_others_move_is_named(
    homed: Controller, write_job
) -> None:
    homed.submit(write_job("long", radius_m=0.06))
    sleep_s(homed.clock, 5.0)
    faults_of(homed, "y").held = True
    sleep_s(homed.clock, 3.0)
    assert homed.status().state == "fault"
    assert "sensor y reads" in homed.status().why
    assert "motor" not in homed.status().why


def test_spikes_of_a_sensor_stop_nothing(homed: Controller, write_job, finish) -> None:
    faults_of(homed, "x").spike_rate = 0.2
    result = finish(homed, homed.submit(write_job()))
    assert result.outcome == "done"


def test_arms_that_sink_alike_and_a_lying_z_are_both_said(homed: Controller) -> None:
    """Nothing else than z changes either way."""
    sleep_s(homed.clock, 3.0)
    faults_of(homed, "z").offset_m = -0.03
    sleep_s(homed.clock, 1.0)
    why = homed.status().why
    assert "drive power lost" in why
    assert re.search("sensor z reads (29|30|31) mm too little", why)


def test_arms_that_would_have_to_leave_their_range_are_not_named(homed: Controller) -> None:
    sleep_s(homed.clock, 3.0)
    faults_of(homed, "z").stuck_m = 1.2
    sleep_s(homed.clock, 1.0)
    why = homed.status().why
    assert "sensor z reads" in why
    assert "drive power" not in why


POSES = st.lists(st.floats(10.0, 70.0), min_size=3, max_size=3)


def changed_m(angles_rad: np.ndarray, turned_rad: np.ndarray) -> np.ndarray:
    """By the whole geometry."""
    assert ROBOT.sensors is not None
    both_m = forward(Linkage.of(ROBOT.geometry), np.array([angles_rad, angles_rad + turned_rad]))
    return (both_m.position_m[1] - both_m.position_m[0]) @ ROBOT.sensors.axes.T


@settings(max_examples=60, deadline=None)
@given(POSES, st.integers(0, 2), st.floats(3.0, 12.0), st.sampled_from([-1, 1]), st.integers(0, 99))
def test_a_motor_that_lost_counts_is_among_the_causes(
    pose_deg: list[float], motor: int, lost_deg: float, sign: int, seed: int
) -> None:
    angles_rad = np.deg2rad(pose_deg)
    turned_rad = np.radians(sign * lost_deg) * np.eye(3)[motor]
    noise_m = 0.0005 * np.random.default_rng(seed).standard_normal(3)
    seen_m = changed_m(angles_rad, turned_rad) + noise_m
    slopes_m = range_slopes_m(ROBOT, angles_rad)
    found = causes(ROBOT, angles_rad, seen_m, np.full(3, 0.0005), slopes_m)
    assert ("motor", motor) in [(one.kind, one.place) for one in found]


@settings(max_examples=60, deadline=None)
@given(POSES, st.integers(0, 2), st.floats(0.02, 0.3), st.sampled_from([-1, 1]), st.integers(0, 99))
def test_a_sensor_that_lies_is_among_the_causes_and_seldom_a_motor(
    pose_deg: list[float], axis: int, off_m: float, sign: int, seed: int
) -> None:
    angles_rad = np.deg2rad(pose_deg)
    noise_m = 0.0005 * np.random.default_rng(seed).standard_normal(3)
    slopes_m = range_slopes_m(ROBOT, angles_rad)
    seen_m = sign * off_m * np.eye(3)[axis] + noise_m
    found = causes(ROBOT, angles_rad, seen_m, np.full(3, 0.0005), slopes_m)
    assert ("sensor", axis) in [(one.kind, one.place) for one in found]
    assert [one.kind for one in found].count("sensor") == 1


def test_no_single_cause_is_said_to_be_none() -> None:
    """Two sensors that lie apart are neither one motor, one sensor nor lost power."""
    angles_rad = np.deg2rad([40.0, 40.0, 40.0])
    seen_m = np.array([0.08, -0.08, 0.0])
    found = causes(ROBOT, angles_rad, seen_m, np.full(3, 0.0005), range_slopes_m(ROBOT, angles_rad))
    assert [one.kind for one in found] == ["unknown"]
