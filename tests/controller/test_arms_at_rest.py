"""The step watch goes on while the robot waits: in READY and PAUSED."""

from __future__ import annotations

import pytest

from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.sensing.step_watch import StepLoss
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import NotReady

NINE_DEG = 400
"""Steps of an arm."""


def push(controller: Controller, *motors: int) -> None:
    assert controller.machine.bench is not None
    for motor in motors:
        controller.machine.bench.slip(motor, NINE_DEG)


def test_an_arm_pushed_while_ready_is_no_longer_homed(homed: Controller, write_job) -> None:
    sleep_s(homed.clock, 10.0)
    assert homed.status().state == "ready"
    push(homed, 2)
    sleep_s(homed.clock, 1.0)
    status = homed.status()
    assert status.state == "unhomed"
    assert status.position_m is None
    assert "the sensors see motor2 about" in status.why
    assert "pushed, or slipped?" in status.why
    with pytest.raises(NotReady, match=r"unhomed \(an arm moved .*deltactl home"):
        homed.submit(write_job())


def test_all_arms_at_once_are_called_lost_power(homed: Controller) -> None:
    sleep_s(homed.clock, 5.0)
    push(homed, 1, 2, 3)
    sleep_s(homed.clock, 1.0)
    assert homed.status().state == "unhomed"
    assert "drive power lost?" in homed.status().why


def test_all_alarms_at_once_are_called_lost_power(homed: Controller) -> None:
    assert homed.machine.bench is not None
    bench = homed.machine.bench
    bench.memory.ask_trips(7)
    bench.lines.refresh()
    sleep_s(homed.clock, 0.05)
    assert homed.status().state == "fault"
    assert homed.status().why == "alarm of all three motors at once: drive power lost?"
    with pytest.raises(OSError, match="all three drives report an alarm at once"):
        homed.acknowledge()


@pytest.mark.study
def test_an_arm_pushed_while_paused_ends_the_job(homed: Controller, write_job) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 5.0)
    homed.pause()
    sleep_s(homed.clock, 5.0)
    assert homed.status().state == "paused"
    push(homed, 3)
    sleep_s(homed.clock, 1.0)
    assert homed.status().state == "fault"
    assert "motor3" in homed.status().why
    assert homed.result(number).outcome == "fault"


@pytest.mark.study
def test_nothing_is_seen_in_a_minute_of_rest(homed: Controller) -> None:
    sleep_s(homed.clock, 60.0)
    assert homed.status().state == "ready"


def test_how_a_loss_of_power_is_told() -> None:
    assert "all three arms" in StepLoss(1, 50, -0.01, all_three=True).says()
    assert "all three" not in StepLoss(1, 50, -0.01).says()
