"""A stop at the worst moments: never overwritten, nothing leaks, nothing runs afterwards."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from deltactl.drivers.steps.contract import Ticks
from deltactl.firmware_py.controller import homing
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.jobs import active_job
from deltactl.firmware_py.controller.states import State
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import DeltactlError, NotReady


def open_recordings() -> list[str]:
    """Descriptors of recordings that this process has open."""
    found = []
    for link in Path("/proc/self/fd").iterdir():
        try:
            target = os.readlink(link)
        except OSError:
            continue
        if target.endswith(".mcap"):
            found.append(target)
    return found


def at_the_first_listen(controller: Controller, monkeypatch: pytest.MonkeyPatch, act) -> None:
    """Have something happen while the homing listens to the sensors."""
    listen, done = controller.ranging.good_readings, []

    def disturbed(since_ns: int):
        if not done:
            done.append(True)
            act()
        return listen(since_ns)

    monkeypatch.setattr(controller.ranging, "good_readings", disturbed)


def test_a_stop_during_homing_is_not_overwritten(controller: Controller, monkeypatch) -> None:
    controller.power_on()
    at_the_first_listen(controller, monkeypatch, lambda: controller.stop("a hand"))
    with pytest.raises(NotReady, match=r"stopped \(a hand\) meanwhile"):
        controller.home()
    status = controller.status()
    assert (status.state, status.why, status.position_m) == ("stopped", "a hand", None)


@pytest.mark.parametrize("times", [1, 2])
def test_a_stop_acknowledged_during_homing_still_ends_it(
    controller: Controller, monkeypatch, times: int
) -> None:
    """Whoever acknowledges says that the cause is gone, not that the arms are home."""
    monkeypatch.setattr(homing, "ENDS_S", 0.1)  # it cannot end before this, within its own call
    controller.power_on()

    def stop_and_acknowledge() -> None:
        for _ in range(times):
            controller.stop("a hand")
            controller.acknowledge()

    at_the_first_listen(controller, monkeypatch, stop_and_acknowledge)
    with pytest.raises(NotReady, match="cannot home: the robot is unhomed"):
        controller.home()
    assert (controller.status().state, controller.status().why) == ("unhomed", "")
    controller.home()
    assert controller.status().state == "ready"


@pytest.mark.study
def test_a_homing_that_was_stopped_moves_nothing_any_more(
    homed: Controller, write_job, finish, monkeypatch
) -> None:
    """Stop and acknowledgement between two pieces of the way home."""
    assert finish(homed, homed.submit(write_job())).outcome == "done"
    output = homed.machine.output
    push, edges = output.push, []

    def disturbed(ticks: Ticks) -> None:
        push(ticks)
        if not edges:
            homed.stop("a hand")
            homed.acknowledge()
            assert homed.machine.bench is not None
            edges.append(homed.machine.bench.memory.edges())

    monkeypatch.setattr(output, "push", disturbed)
    with pytest.raises(DeltactlError):
        homed.home()
    sleep_s(homed.clock, 5.0)
    assert homed.machine.bench is not None
    assert [homed.machine.bench.memory.edges()] == edges
    assert homed.status().state == "unhomed"


def test_two_homings_at_once_are_one_too_many(controller: Controller, monkeypatch) -> None:
    controller.power_on()
    refused = []

    def home_again() -> None:
        with pytest.raises(NotReady, match="the robot is homing") as error:
            controller.home()
        refused.append(error)

    at_the_first_listen(controller, monkeypatch, home_again)
    controller.home()
    assert refused
    assert controller.status().state == "ready"


def test_switching_off_during_homing_ends_it(controller: Controller, monkeypatch) -> None:
    controller.power_on()
    at_the_first_listen(controller, monkeypatch, controller.power_off)
    with pytest.raises(NotReady, match="cannot home: the robot was switched off"):
        controller.home()
    assert controller.status().state == "off"
    controller.power_on()
    controller.home()


def test_a_stop_between_begin_and_the_first_feed_leaks_nothing(
    homed: Controller, write_job, finish, monkeypatch
) -> None:
    recorder_of, before = active_job.RunRecorder, open_recordings()

    def stop_then_open(*arguments, **named):
        homed.machine.output.stop("a hand")
        return recorder_of(*arguments, **named)

    monkeypatch.setattr(active_job, "RunRecorder", stop_then_open)
    number = homed.submit(write_job())
    waiting = homed.submit(write_job("waiting"))
    sleep_s(homed.clock, 1.0)
    result = finish(homed, number)
    assert (result.outcome, result.why) == ("stopped", "a hand")
    assert finish(homed, waiting).outcome in ("stopped", "fault")
    assert open_recordings() == before
    assert homed.journal.path is None
    assert homed.status().queued == ()
    monkeypatch.setattr(active_job, "RunRecorder", recorder_of)
    assert homed.machine.bench is not None
    edges = homed.machine.bench.memory.edges()
    homed.acknowledge()
    sleep_s(homed.clock, 2.0)
    assert homed.machine.bench.memory.edges() == edges
    assert homed.status().state == "unhomed"


@pytest.mark.parametrize("times", [1, 2])
def test_a_queue_does_not_outlive_a_stop(homed: Controller, write_job, finish, times: int) -> None:
    first = homed.submit(write_job())
    second = homed.submit(write_job("second"))
    sleep_s(homed.clock, 2.0)
    for _ in range(times):
        homed.stop("a hand")
    assert homed.status().queued == ()
    assert finish(homed, first).outcome == "stopped"
    assert finish(homed, second).outcome == "stopped"
    homed.power_off()
    homed.acknowledge()
    homed.home()
    assert homed.machine.bench is not None
    edges = homed.machine.bench.memory.edges()
    sleep_s(homed.clock, 5.0)
    assert homed.machine.bench.memory.edges() == edges
    assert homed.status().state == "ready"


def test_a_job_that_was_being_checked_when_the_robot_stopped_is_not_run(
    homed: Controller, write_job, monkeypatch
) -> None:
    """Even where the robot is stopped, acknowledged and homed again before the check ends."""
    prepare = homed._prepare

    def slowly(*arguments):
        homed.stop("a hand")
        homed.acknowledge()
        homed.home()
        return prepare(*arguments)

    monkeypatch.setattr(homed, "_prepare", slowly)
    with pytest.raises(NotReady, match="cannot run"):
        homed.submit(write_job())
    assert homed.status().queued == ()


def test_a_job_that_was_being_checked_when_an_arm_was_pushed_is_not_run(
    homed: Controller, write_job, monkeypatch
) -> None:
    """It would be begun from counts that mean nothing any more, once somebody homes."""
    prepare = homed._prepare

    def slowly(*arguments):
        homed.condition.enter(State.UNHOMED, "an arm moved")
        return prepare(*arguments)

    monkeypatch.setattr(homed, "_prepare", slowly)
    with pytest.raises(NotReady, match=r"unhomed \(an arm moved\)"):
        homed.submit(write_job())
    assert homed.status().queued == ()


def test_a_stop_while_switching_on_stays(controller: Controller, monkeypatch) -> None:
    enable = controller.machine.output.enable

    def disturbed() -> None:
        enable()
        controller.stop("a hand")
        sleep_s(controller.clock, 0.05)

    monkeypatch.setattr(controller.machine.output, "enable", disturbed)
    with pytest.raises(NotReady, match="cannot switch on"):
        controller.power_on()
    assert controller.status().state == "stopped"


def test_a_stop_while_acknowledging_stays(homed: Controller, monkeypatch) -> None:
    homed.stop("first")
    enable = homed.machine.output.enable

    def disturbed() -> None:
        enable()
        homed.stop("second")

    monkeypatch.setattr(homed.machine.output, "enable", disturbed)
    with pytest.raises(NotReady, match="cannot acknowledge"):
        homed.acknowledge()
    assert homed.status().state == "stopped"


def test_the_first_reason_of_a_stop_stays(homed: Controller, write_job, finish) -> None:
    number = homed.submit(write_job())
    sleep_s(homed.clock, 2.0)
    homed.stop("first")
    homed.stop("second")
    sleep_s(homed.clock, 0.1)
    assert finish(homed, number).why == "first"
    assert homed.machine.output.status().reason == "first"
    assert homed.status().why == "first"
