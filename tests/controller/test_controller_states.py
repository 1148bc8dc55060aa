"""Which request is taken in which state, homing, and the latched stop."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.states import ALLOWED, Request, State, require, said, way_out
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import EmergencyStop, NotReady


@pytest.mark.parametrize("request_", list(Request))
@pytest.mark.parametrize("state", list(State))
def test_a_refusal_says_what_to_do(request_: Request, state: State) -> None:
    if state in ALLOWED[request_]:
        require(request_, state)
        return
    with pytest.raises(NotReady) as refused:
        require(request_, state)
    assert state.value in str(refused.value)
    assert way_out(state) in str(refused.value)


@pytest.mark.parametrize("state", [State.OFF, State.UNHOMED, State.STOPPED, State.FAULT])
def test_only_a_robot_with_hands_near_it_is_to_be_put_against_its_stops(state: State) -> None:
    assert "put the arms against their stops, 'deltactl home'" in way_out(state)
    assert way_out(state, simulated=True).endswith("'deltactl home'")
    assert "put" not in way_out(state, simulated=True)


def test_the_controller_refuses_what_the_table_refuses(homed: Controller, write_job) -> None:
    """In one line that says what to do; a pause with nothing to pause is no crash."""
    job = write_job()
    asks = {
        Request.ON: homed.power_on,
        Request.OFF: homed.power_off,
        Request.HOME: homed.home,
        Request.RUN: lambda: homed.submit(job),
        Request.PAUSE: homed.pause,
        Request.RESUME: homed.resume,
        Request.CANCEL: homed.cancel,
        Request.ACKNOWLEDGE: homed.acknowledge,
    }
    for state, (request_, ask) in product(State, asks.items()):
        if state not in ALLOWED[request_]:
            homed.condition.state = state
            with pytest.raises(NotReady, match=f"cannot .* is {said(state)}"):
                ask()
            assert homed.condition.state is state
    homed.condition.state = State.READY
    assert homed.machine.output.status().queued == 0


def test_on_home_off(controller: Controller) -> None:
    assert controller.status().state == "off"
    controller.power_on()
    assert controller.status().state == "unhomed"
    assert controller.status().angles_rad is None
    controller.home()
    status = controller.status()
    assert status.state == "ready"
    assert status.angles_rad is not None
    np.testing.assert_allclose(np.rad2deg(status.angles_rad), 30.0, atol=0.0225)
    controller.power_off()
    assert controller.status().state == "off"
    controller.power_on()
    assert controller.status().state == "unhomed"


def test_the_journal_says_what_was_seen_when_homing(
    controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It opens the next recording: how far off the arms may have been stands there."""
    events: list[tuple[int, str, str]] = []
    monkeypatch.setattr(controller.journal, "event", lambda *event: events.append(event))
    controller.power_on()
    said = controller.home()
    assert [text for _, kind, text in events if kind == "home"] == [said.says()]
    assert [text for _, kind, text in events if kind == "state"] == ["unhomed", "homing", "ready"]


def test_nothing_runs_unhomed(controller: Controller, write_job) -> None:
    controller.power_on()
    with pytest.raises(NotReady, match=r"unhomed.*deltactl home"):
        controller.submit(write_job())


def test_homing_is_refused_when_the_sensors_disagree(
    controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    controller.power_on()
    world = controller.machine.world
    assert world is not None
    monkeypatch.setattr(world, "put_to_stops", lambda t_ns: None)  # nobody puts them back
    world._zero_steps = world._zero_steps + 400.0  # somebody moved the arms by 9 degrees
    sleep_s(controller.clock, 0.2)
    with pytest.raises(NotReady, match=r"sensor z reads .* but .* is expected"):
        controller.home()
    assert (controller.status().state, controller.status().why) == ("unhomed", "")


def test_homed_after_a_stop_the_simulated_robot_really_is_at_home(
    homed: Controller, write_job, finish
) -> None:
    """25 mm off its sensors would still have let it pass, and all jobs would have been off."""
    world = homed.machine.world
    assert world is not None
    at_home = world.truth(homed.clock.now_ns()).angles_rad
    number = homed.submit(write_job())
    sleep_s(homed.clock, 1.0)
    homed.stop("in mid-path")
    finish(homed, number)
    where = world.truth(homed.clock.now_ns()).angles_rad
    assert np.abs(np.subtract(where, at_home)).max() > 0.01
    homed.acknowledge()
    homed.home()
    there = world.truth(homed.clock.now_ns()).angles_rad
    np.testing.assert_allclose(there, at_home, atol=2e-3)
    assert homed.status().counts == (1333, 1333, 1333)


@pytest.mark.study
def test_homing_again_drives_back_to_the_home_angles(homed: Controller, write_job, finish) -> None:
    assert finish(homed, homed.submit(write_job())).outcome == "done"
    assert homed.status().counts != (1333, 1333, 1333)
    homed.home()
    assert homed.status().state == "ready"
    assert homed.status().counts == (1333, 1333, 1333)


def test_the_emergency_stop_is_latched(homed: Controller) -> None:
    bench = homed.machine.bench
    assert bench is not None
    bench.press_estop()
    sleep_s(homed.clock, 0.05)
    assert homed.status().state == "stopped"
    with pytest.raises(NotReady, match="acknowledge"):
        homed.home()
    with pytest.raises(EmergencyStop):
        homed.acknowledge()
    bench.release_estop()
    sleep_s(homed.clock, 0.05)
    assert homed.status().state == "stopped"
    homed.acknowledge()
    assert homed.status().state == "unhomed"


def test_progress_grows_in_every_resting_state(controller: Controller) -> None:
    for enter in (lambda: None, controller.power_on, controller.home):
        enter()
        before = controller.progress_count()
        sleep_s(controller.clock, 0.2)
        assert controller.progress_count() > before


def test_switching_off_releases_the_drives_but_not_the_latch(homed: Controller) -> None:
    bench = homed.machine.bench
    assert bench is not None
    bench.trip(3)
    sleep_s(homed.clock, 0.05)
    assert (homed.status().state, homed.status().why) == ("fault", "alarm motor3")
    homed.power_off()
    assert not homed.machine.output.status().energised
    sleep_s(homed.clock, 0.05)
    assert (homed.status().state, homed.status().why) == ("fault", "alarm motor3")
    homed.acknowledge()
    homed.home()
    assert homed.status().state == "ready"


@pytest.mark.study
@pytest.mark.parametrize("stopped_meanwhile", [True, False])
def test_an_error_while_feeding_can_be_acknowledged(
    homed: Controller, write_job, finish, monkeypatch, stopped_meanwhile: bool
) -> None:
    """A stop that comes between the look at the output and the feeding; or a mistake of ours."""
    homed.submit(write_job())
    sleep_s(homed.clock, 0.5)
    assert homed.jobs.running is not None
    advance = homed.jobs.running.advance

    def disturbed(now_ns: int) -> None:
        if not stopped_meanwhile:
            raise RuntimeError("a mistake")
        homed.machine.output.stop("a hand in the way")
        advance(now_ns)

    monkeypatch.setattr(homed.jobs.running, "advance", disturbed)
    sleep_s(homed.clock, 0.05)
    why = "a hand in the way" if stopped_meanwhile else "a mistake"
    assert (homed.status().state, homed.status().why) == ("fault", why)
    homed.power_off()
    homed.acknowledge()
    homed.home()
    assert finish(homed, homed.submit(write_job("again"))).outcome == "done"
