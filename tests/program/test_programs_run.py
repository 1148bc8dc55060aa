"""Jobs of steps on the simulated robot: what is switched when, what is waited for, what stops."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.controller.claim import Claim, Owner
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.jobs import active_job
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.program.totals import check_job
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import MotionError
from deltactl.foundation.strict_yaml import Document
from deltactl.recording.reading.reader import read_run
from tests.program.conftest import Write, finished

UP = "  - path: {shape: points, points_m: [[0.0, 0.0, -0.3]]}\n"
SIDE = "  - path: {shape: points, points_m: [[0.04, 0.0, -0.3]]}\n"
GRIP = "  - set: {gripper: on}\n"
WAIT = "  - wait_for: {input: part_there, within_s: 3}\n"


def test_a_part_is_picked_and_placed_three_times(folder: Path, controller: Controller) -> None:
    number = controller.submit(folder / "pick-and-place.yaml", folder / "run.mcap")
    result = finished(controller, number)
    assert (result.outcome, result.why) == ("done", "")
    run = read_run(folder / "run.mcap")
    said = [(e.kind, e.text) for e in run.events if e.kind in ("output", "wait", "path_end")]
    once = [
        ("wait", "for part_there to be on"), ("path_end", "done"), ("output", "gripper on"),
        ("path_end", "done"), ("path_end", "done"), ("output", "gripper off"),
    ]  # fmt: skip
    assert said == once * 3
    took_s = run.events[-1].t_ns * 1e-9
    assert took_s == pytest.approx(check_job(folder / "pick-and-place.yaml").duration_s, abs=1.0)
    whole = Document(Path("in.yaml"), run.configuration.job_text).check(JobFile)
    assert "include" not in run.configuration.job_text
    assert whole.steps is not None


def test_an_input_that_does_not_come_cancels_the_job(write: Write, controller: Controller) -> None:
    bench = controller.machine.bench
    assert bench is not None
    bench.set_input("part_there", False)
    number = controller.submit(write(UP + GRIP + WAIT + SIDE))
    result = finished(controller, number)
    assert (result.outcome, result.why) == (
        "cancelled", "waited 3 s for part_there to be on, in vain",
    )  # fmt: skip
    status = controller.status()
    assert status.state == "ready"
    assert status.position_m is not None
    assert abs(status.position_m[0]) < 1e-4  # it did not go to the side
    assert bench.outputs() == {"gripper": False}


@pytest.mark.study
def test_it_goes_on_as_soon_as_the_input_comes(write: Write, controller: Controller) -> None:
    bench = controller.machine.bench
    assert bench is not None
    bench.set_input("part_there", False)
    number = controller.submit(write(UP + GRIP + WAIT + SIDE))
    while not bench.outputs()["gripper"]:
        sleep_s(controller.clock, 0.05)
    controller.pause()
    sleep_s(controller.clock, 10.0)  # the time of a wait stands still meanwhile
    controller.resume()
    sleep_s(controller.clock, 1.0)
    assert controller.status().state == "running"
    bench.set_input("part_there", True)
    assert finished(controller, number).outcome == "done"
    assert controller.status().outputs == bench.outputs() == {"gripper": True}
    assert controller.status().inputs == {"part_there": True}


@pytest.mark.parametrize("how", ["e-stop", "stop", "cancel", "off", "alarm"])
def test_whatever_ends_a_job_lets_go(write: Write, controller: Controller, how: str) -> None:
    bench = controller.machine.bench
    assert bench is not None
    number = controller.submit(write(UP + GRIP + "  - wait_s: 0.5\n" + SIDE))
    while not bench.outputs()["gripper"]:
        sleep_s(controller.clock, 0.05)
    ways = {
        "e-stop": bench.press_estop,
        "stop": lambda: controller.stop("by hand"),
        "cancel": controller.cancel,
        "off": lambda: None,
        "alarm": lambda: bench.trip(1),
    }
    ways[how]()
    ended = finished(controller, number)
    if how == "off":
        assert bench.outputs() == {"gripper": True}  # a job that is done leaves it as it is
        controller.power_off()
    sleep_s(controller.clock, 0.1)
    assert bench.outputs() == {"gripper": False}
    outcomes = {"cancel": "cancelled", "off": "done", "alarm": "fault"}
    assert ended.outcome == outcomes.get(how, "stopped")


@pytest.mark.parametrize("how", ["cancel", "client", "cancel by number"])
def test_what_ends_a_job_in_its_last_moment_lets_go(
    write: Write, controller: Controller, how: str
) -> None:
    """All is done, and only the last readings are waited for."""
    bench = controller.machine.bench
    assert bench is not None
    owner = Owner()
    number = controller.submit(write(UP + GRIP), claim=Claim(owner))
    while not bench.outputs()["gripper"]:
        sleep_s(controller.clock, 0.02)
    assert controller.status().state == "running"
    ways = {
        "cancel": controller.cancel,
        "client": lambda: controller.leave(owner),
        "cancel by number": lambda: controller.cancel(number),
    }
    ways[how]()
    assert finished(controller, number).outcome == "cancelled"
    assert bench.outputs() == {"gripper": False}


def test_a_job_that_fails_as_it_begins_lets_go(
    write: Write, controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It has switched an output, and then cannot move: the network's file has gone, say."""
    bench = controller.machine.bench
    assert bench is not None

    def fails(*ignored: object) -> None:
        raise MotionError("the way in is not possible any more")

    monkeypatch.setattr(active_job, "MotionStream", fails)
    number = controller.submit(write(GRIP + UP))
    ended = finished(controller, number)
    assert ended.outcome == "refused"
    assert bench.outputs() == {"gripper": False}
    assert controller.status().state == "ready"


def test_repeats_of_the_whole_and_of_a_part(write: Write, controller: Controller) -> None:
    steps = f"  - repeat: 2\n    steps:\n    - {GRIP.strip()[2:]}\n    - set: {{gripper: off}}\n"
    head_repeats = write(steps + SIDE + UP)
    head_repeats.write_text(head_repeats.read_text() + "repeats: 3\n")
    assert check_job(head_repeats).instructions == 3 * (2 * 2 + 2)
    number = controller.submit(head_repeats, head_repeats.with_suffix(".mcap"))
    assert finished(controller, number).outcome == "done"
    events = read_run(head_repeats.with_suffix(".mcap")).events
    assert sum(e.text == "gripper on" for e in events) == 6
    assert sum(e.kind == "path_end" for e in events) == 6
