"""No state from which no command leads out: a search over states, requests and mishaps."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.states import ALLOWED, Request, State
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import DeltactlError

ROBOT_FILE = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"
DEPTH = 2
Act = Callable[[Controller, Path], None]


def press(controller: Controller, job: Path) -> None:
    assert controller.machine.bench is not None
    controller.machine.bench.press_estop()


def trip(controller: Controller, job: Path) -> None:
    assert controller.machine.bench is not None
    controller.machine.bench.trip(2)


def push(controller: Controller, job: Path) -> None:
    assert controller.machine.bench is not None
    controller.machine.bench.slip(1, 400)
    sleep_s(controller.clock, 1.0)


def take_light(controller: Controller, job: Path) -> None:
    assert controller.machine.rig is not None
    controller.machine.rig.chips["z"].faults.raw_status = 4
    sleep_s(controller.clock, 1.0)


def stick(controller: Controller, job: Path) -> None:
    assert controller.machine.rig is not None
    controller.machine.rig.bus.stuck = True
    sleep_s(controller.clock, 1.0)


def err(controller: Controller, job: Path) -> None:
    controller._on_loop_error(RuntimeError("a mistake"))


ACTS: dict[str, Act] = {
    "on": lambda controller, job: controller.power_on(),
    "off": lambda controller, job: controller.power_off(),
    "home": lambda controller, job: controller.home(),
    "run": lambda controller, job: controller.submit(job) and None,
    "pause": lambda controller, job: controller.pause(),
    "resume": lambda controller, job: controller.resume(),
    "cancel": lambda controller, job: controller.cancel(),
    "stop": lambda controller, job: controller.stop("a hand"),
    "acknowledge": lambda controller, job: controller.acknowledge(),
    "e-stop": press,
    "alarm": trip,
    "push": push,
    "no light": take_light,
    "bus held": stick,
    "mistake": err,
}


def mend(controller: Controller) -> None:
    """Every cause outside the program is taken away."""
    assert controller.machine.bench is not None
    assert controller.machine.rig is not None
    controller.machine.bench.release_estop()
    controller.machine.bench.lines.cycle_power()
    controller.machine.rig.bus.stuck = False
    for chip in controller.machine.rig.chips.values():
        chip.faults.clear()


WAY = ("cancel", "off", "acknowledge", "off", "on", "home")
"""What a person does who knows nothing of what came before; refusals are taken as they come."""


def walk(folder: Path, steps: tuple[str, ...], job: Path) -> Controller:
    controller = build_controller(ROBOT_FILE, simulated=True, realtime=False, recordings=folder)
    for step in steps:
        with suppress(DeltactlError):
            ACTS[step](controller, job)
        sleep_s(controller.clock, 0.05)
    return controller


def mark(controller: Controller) -> tuple[object, ...]:
    """What the next steps can depend on, as far as it can be seen."""
    assert controller.machine.bench is not None
    assert controller.machine.rig is not None
    output = controller.machine.output.status()
    return (
        controller.condition.state,
        output.state,
        output.energised,
        controller.jobs.running is not None,
        bool(controller.jobs.queue),
        controller.machine.bench.memory.estop_pressed,
        bool(controller.machine.bench.memory.alarms),
        controller.machine.rig.bus.stuck,
        controller.machine.rig.chips["z"].faults.raw_status,
        controller.condition.why.split(" ")[0],
    )


@pytest.mark.study
def test_from_every_state_that_can_be_reached_a_way_leads_to_ready(tmp_path, write_job) -> None:
    job = write_job()
    seen: set[tuple[object, ...]] = set()
    usual = ("on", "home", "run", "pause")
    paths = deque((usual[:count], count + DEPTH - 1) for count in range(len(usual) + 1))
    tried = 0
    while paths:
        path, limit = paths.popleft()
        controller = walk(tmp_path, path, job)
        known, reached = mark(controller), controller.condition.state
        new = known not in seen
        seen.add(known)
        if new:
            tried += 1
            _must_lead_out(controller, job, path, reached)
            if len(path) < limit:
                paths.extend(((*path, name), limit) for name in ACTS)
        controller.close()
    passing = {State.HOMING, State.PLANNING}  # they end as their request does, within each step
    assert {state for (state, *_) in seen} == set(State) - passing
    assert tried >= 15


def _must_lead_out(
    controller: Controller, job: Path, path: tuple[str, ...], reached: State
) -> None:
    mend(controller)
    for step in WAY:
        with suppress(DeltactlError):
            ACTS[step](controller, job)
        sleep_s(controller.clock, 0.5)
    assert controller.condition.state is State.READY, f"{path} leads to {reached}, and no way out"


def test_every_state_has_a_request_that_changes_it() -> None:
    for state in State:
        leaving = [one for one in Request if one is not Request.STOP and state in ALLOWED[one]]
        assert leaving, state


@pytest.mark.parametrize("state", list(State))
def test_a_stop_is_taken_in_every_state(state: State) -> None:
    assert state in ALLOWED[Request.STOP]
