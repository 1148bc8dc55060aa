"""A controller that hung for longer than the heartbeat in mid-motion does not just go on.

The player alone does not notice: its queue ran dry before, and at rest it needs no heartbeat.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.states import State
from deltactl.foundation.clock import sleep_s
from tests.controller.conftest import WriteJob

LONGER, SHORTER = 1.2, 0.8
"""Of the heartbeat, less a round of the control loop."""


def hang_in_a_job(
    controller: Controller, job: Path, part: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One round of the control loop waits for a core, while the pulses are played on."""
    output, clock = controller.machine.output, controller.clock
    controller.submit(job)
    while controller.status().state != State.RUNNING.value:
        sleep_s(clock, 0.02)
    sleep_s(clock, 0.5)
    beat, hangs = type(output).beat, [part * controller.robot.steps.heartbeat_s]

    def late(*given: object) -> None:
        if hangs:
            sleep_s(clock, hangs.pop())
        beat(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(type(output), "beat", late)
    sleep_s(clock, 0.6)


def test_a_hang_longer_than_the_heartbeat_ends_the_motion(
    homed: Controller, write_job: WriteJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    hang_in_a_job(homed, write_job(), LONGER, monkeypatch)
    status = homed.status()
    assert status.state in (State.STOPPED.value, State.FAULT.value)
    assert "no heartbeat" in status.why
    before = homed.machine.output.status().counts
    sleep_s(homed.clock, 1.0)
    assert homed.machine.output.status().counts == before


def test_a_shorter_hang_is_none(
    homed: Controller, write_job: WriteJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    hang_in_a_job(homed, write_job(), SHORTER, monkeypatch)
    assert homed.status().state == State.RUNNING.value
