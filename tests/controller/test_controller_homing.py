"""Homing by switches, and sensors that are missing or stop."""

from __future__ import annotations

from contextlib import closing
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import BusDead, NotReady, SensorFault
from deltactl.recording.reading.reader import read_run


@pytest.fixture
def switched(tmp_path: Path):
    text = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
    assert "method: placed" in text
    robot = tmp_path / "switched.yaml"
    robot.write_text(text.replace("method: placed", "method: switch\n  switch_pins: [12, 16, 18]"))
    made = build_controller(robot, simulated=True, realtime=False, recordings=tmp_path)
    made.power_on()
    yield made
    made.close()


def test_arms_find_their_switches(switched: Controller) -> None:
    world = switched.machine.world
    assert world is not None
    hanging = np.rad2deg(world.truth(switched.clock.now_ns()).angles_rad)
    assert np.all(hanging > 40.0)
    switched.home()
    status = switched.status()
    assert status.state == "ready"
    sleep_s(switched.clock, 0.1)
    truth_rad = np.array(world.truth(switched.clock.now_ns()).angles_rad)
    assert status.angles_rad is not None
    # The slow approach overshoots by what one look of 20 ms moves, at a fifth of 0.1 rad/s.
    np.testing.assert_allclose(truth_rad, status.angles_rad, atol=0.02 * 0.1 / 5 + 0.0004)


def test_a_missing_sensor_is_named_when_switched_on(controller: Controller) -> None:
    rig = controller.machine.rig
    assert rig is not None
    rig.chips["y"].faults.unpowered = True
    with pytest.raises(SensorFault, match=r"sensor y"):
        controller.power_on()
    assert controller.status().state == "off"
    rig.chips["y"].faults.unpowered = False
    controller.power_on()
    assert controller.status().state == "unhomed"


def test_a_dead_bus_is_named_when_switched_on(controller: Controller) -> None:
    rig = controller.machine.rig
    assert rig is not None
    rig.bus.stuck = True
    with pytest.raises(BusDead, match=r"\bSDA\b|\bbus\b"):
        controller.power_on()
    assert controller.status().state == "off"


def test_a_sensor_that_stumbles_is_restarted_while_the_job_goes_on(
    homed: Controller, write_job, finish
) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 3.0)
    rig = homed.machine.rig
    assert rig is not None
    rig.chips["z"].brown_out()
    result = finish(homed, number)
    assert result.outcome == "done"
    assert all(sensor.health == "ok" for sensor in homed.status().sensors)
    events = [event.text for event in read_run(Path(result.recording)).events]
    assert any("brown-out: it answers at 0x29" in text for text in events)


def test_a_sensor_that_is_gone_stops_the_robot_and_is_named(
    homed: Controller, write_job, finish
) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 2.0)
    rig = homed.machine.rig
    assert rig is not None
    rig.chips["z"].faults.unpowered = True
    result = finish(homed, number)
    assert result.outcome == "fault"
    assert "sensor z" in result.why


@pytest.mark.study
def test_a_step_that_takes_longer_than_a_look_is_waited_for(tmp_path: Path) -> None:
    """At a slow speed a step takes 0.1 s, and 0.5 s in the slow approach."""
    text = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
    homing = "method: switch\n  switch_pins: [12, 16, 18]\n  speed_radps: 0.004"
    robot = tmp_path / "slow.yaml"
    robot.write_text(text.replace("method: placed", homing))
    made = build_controller(robot, simulated=True, realtime=False, recordings=tmp_path)
    with closing(made):
        made.power_on()
        assert made.machine.bench is not None
        for motor in (1, 2, 3):
            made.machine.bench.slip(motor, 500)  # near its switch
        made.home()
        status = made.status()
        assert status.state == "ready"
        assert made.machine.world is not None
        truth_rad = made.machine.world.truth(made.clock.now_ns()).angles_rad
        np.testing.assert_allclose(truth_rad, status.angles_rad, atol=0.0008)


def test_sensors_that_are_back_are_started_by_an_acknowledgement(homed: Controller) -> None:
    rig = homed.machine.rig
    assert rig is not None
    rig.chips["z"].faults.unpowered = True
    for _ in range(200):
        sleep_s(homed.clock, 0.1)
        if homed.status().state == "fault":
            break
    rig.chips["z"].faults.unpowered = False
    homed.acknowledge()
    homed.home()
    assert homed.status().state == "ready"
    assert all(sensor.health == "ok" for sensor in homed.status().sensors)


def stuck(switched: Controller, motor: int, closed: bool) -> None:
    switches = list(switched.machine.home_switches)
    switches[motor] = lambda: closed
    object.__setattr__(switched.machine, "home_switches", tuple(switches))


@pytest.mark.parametrize("motor", [0, 2])
@pytest.mark.parametrize(("closed", "named"), [(True, "stuck closed"), (False, "stuck open")])
def test_a_switch_that_is_stuck_is_named(
    switched: Controller, motor: int, closed: bool, named: str
) -> None:
    stuck(switched, motor, closed)
    with pytest.raises(NotReady, match=rf"switch of arm {motor + 1} .*{named}"):
        switched.home()
    assert switched.status().state == "unhomed"


def test_a_switch_that_sticks_once_it_has_closed_is_named(switched: Controller) -> None:
    pressed = switched.machine.home_switches[1]
    met: list[bool] = []

    def sticks() -> bool:
        met.append(pressed() or (met[-1] if met else False))
        return met[-1]

    switches = list(switched.machine.home_switches)
    switches[1] = sticks
    object.__setattr__(switched.machine, "home_switches", tuple(switches))
    with pytest.raises(
        NotReady, match=r"arm 2 is closed after the arm has reached it.*stuck closed"
    ):
        switched.home()


@pytest.mark.study
def test_homing_again_begins_at_the_switches(switched: Controller) -> None:
    """The arms stand at them, and they are closed: no fault, they are left and sought again."""
    switched.home()
    used = [0, 0, 0]
    switches = list(switched.machine.home_switches)

    def asked(motor: int) -> bool:
        closed = switches[motor]()
        used[motor] |= 2 if closed else 1
        return closed

    watched = tuple(partial(asked, motor) for motor in range(3))
    object.__setattr__(switched.machine, "home_switches", watched)
    switched.home()
    assert used == [3, 3, 3]  # each was seen open and closed
    status = switched.status()
    assert status.state == "ready"
    world = switched.machine.world
    assert world is not None
    truth_rad = world.truth(switched.clock.now_ns()).angles_rad
    np.testing.assert_allclose(truth_rad, status.angles_rad, atol=0.02 * 0.1 / 5 + 0.0004)
