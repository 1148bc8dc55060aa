"""A job that waits for a person: it pauses by itself, says why, and goes on by `resume` alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.program.totals import check_job
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import ConfigError
from deltactl.recording.reading.reader import read_run
from tests.program.conftest import Write, finished

UP = "  - path: {shape: points, points_m: [[0.0, 0.0, -0.3]]}\n"
SIDE = "  - path: {shape: points, points_m: [[0.04, 0.0, -0.3]]}\n"
PAUSE = "  - pause: swap the part\n"


def paused(controller: Controller, limit_s: float = 60.0) -> None:
    """Wait until the job pauses."""
    for _ in range(int(limit_s / 0.05)):
        if controller.status().state == "paused":
            return
        sleep_s(controller.clock, 0.05)
    pytest.fail(f"the job did not pause: {controller.status().state}")


@pytest.mark.study
def test_it_stands_still_until_it_is_resumed(
    write: Write, controller: Controller, folder: Path
) -> None:
    grip = "  - set: {gripper: on}\n"
    number = controller.submit(write(UP + grip + PAUSE + SIDE), folder / "run.mcap")
    paused(controller)
    status = controller.status()
    assert status.why == "swap the part"
    assert status.outputs == {"gripper": True}
    sleep_s(controller.clock, 30.0)
    later = controller.status()
    assert (later.state, later.counts) == ("paused", status.counts)
    controller.resume()
    assert finished(controller, number).outcome == "done"
    place = controller.status().position_m
    assert place is not None
    assert place[0] == pytest.approx(0.04, abs=1e-3)
    events = [(e.kind, e.text) for e in read_run(folder / "run.mcap").events]
    assert ("pause", "swap the part") in events


def test_it_pauses_each_time_round_and_where_a_job_begins_and_ends(
    write: Write, controller: Controller
) -> None:
    number = controller.submit(write(f"  - repeat: 2\n    steps:\n    - pause: a\n  {UP}{PAUSE}"))
    for why in ("a", "a", "swap the part"):
        paused(controller)
        assert controller.status().why == why
        controller.resume()
        sleep_s(controller.clock, 0.05)
    assert finished(controller, number).outcome == "done"


@pytest.mark.parametrize("how", ["cancel", "stop"])
def test_a_job_that_was_called_off_while_it_waits_does_not_go_on(
    write: Write, controller: Controller, how: str
) -> None:
    number = controller.submit(write(UP + PAUSE + SIDE))
    paused(controller)
    counts = controller.status().counts
    if how == "cancel":
        controller.cancel()
    else:
        controller.stop("test")
    assert finished(controller, number).outcome in ("cancelled", "stopped")
    sleep_s(controller.clock, 10.0)
    assert controller.status().counts == counts


def test_check_says_how_often_a_person_is_waited_for(write: Write) -> None:
    assert check_job(write(UP + PAUSE + "  - repeat: 3\n    steps: [{pause: b}]\n")).pauses == 4


@pytest.mark.parametrize("step", ["  - pause: ''\n", "  - pause: 5\n", f"  - pause: {'x' * 201}\n"])
def test_a_pause_says_why(write: Write, step: str) -> None:
    with pytest.raises(ConfigError, match=r"steps\.yaml:\d+: steps\.1\.pause"):
        check_job(write(UP + step))
