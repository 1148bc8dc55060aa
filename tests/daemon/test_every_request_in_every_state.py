"""The robot's table of behaviour, row by row, and walked at random by two clients, with faults."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.stateful import run_state_machine_as_test

from deltactl.firmware_py.controller.states import TABLE, Event, Happening, Request, State
from tests.rigs.table_walk import BY_THEMSELVES, WHILE_HOMING, Robot, taken, walked

STEPS_EACH = 50


@pytest.mark.parametrize("walks", [8, pytest.param(62, marks=pytest.mark.study)])
def test_no_edge_is_sent_that_no_accepted_request_covers(walks: int) -> None:
    walked.clear()
    run_state_machine_as_test(
        Robot,
        settings=settings(
            max_examples=walks,
            stateful_step_count=STEPS_EACH,
            deadline=None,
            derandomize=True,
            phases=(Phase.generate,),
            database=None,
            print_blob=False,
            suppress_health_check=list(HealthCheck),
        ),
    )
    assert sum(walked.values()) >= 0.6 * walks * STEPS_EACH


def test_every_row_of_the_table() -> None:
    """Each event in each state, refusals too; of jobs that are planned, and about to begin."""
    walked.clear()
    machine = Robot()
    machine.switched_on()
    try:
        for state, event, checked in product(State, (*Request, *Happening), (True, False)):
            once = state not in (State.PLANNING, State.PAUSED)
            if state is State.HOMING or event in BY_THEMSELVES or (once and not checked):
                continue
            _bring(machine, state, checked)
            _do(machine, event)
            machine.nothing_waits_where_nothing_may_run()
            machine.time_passes(0.02)
        for event in WHILE_HOMING:
            _bring(machine, State.READY)
            machine.home_called_off(0, event, 0.03)
    finally:
        machine.teardown()
    rows = {(event, state) for event, rules in TABLE.items() for state in rules}
    rows -= {(event, state) for event in BY_THEMSELVES for state in State}
    refused = {(request, state) for request in Request for state in State} - rows
    missed = {f"{event.name} in {state.name}" for event, state in rows}
    missed |= {f"{event.name} refused in {state.name}" for event, state in refused}
    assert {row for row in missed if row not in walked} == {
        "ESTOP in HOMING",  # seen by the loop, as a fault is
        *(f"{one} refused in HOMING" for one in ("ON", "HOME", "RUN", "ACKNOWLEDGE")),  # they wait
        *(f"{one} refused in HOMING" for one in ("PAUSE", "RESUME")),
    }


def _bring(machine: Robot, state: State, checked: bool = True) -> None:
    """Into a state; a job there is `checked` and has not begun, or is being planned."""
    machine.stop(1)
    machine.acknowledge(1)
    if state in (State.READY, State.PLANNING, State.RUNNING, State.PAUSED):
        machine.home(1)
    if state in (State.PLANNING, State.RUNNING, State.PAUSED):
        machine.run(0, "round", False)
    if state is State.RUNNING or (checked and state in (State.PLANNING, State.PAUSED)):
        machine.planned()
    if state is State.RUNNING:
        machine.time_passes(0.2)
    elif state is State.PAUSED:
        machine.pause(0)
    elif state is State.OFF:
        machine.off(0)
    elif state is State.STOPPED:
        machine.stop(0)
    elif state is State.FAULT:
        machine.fault("mistake", 1)
    assert machine.robot.state is state


def _do(machine: Robot, event: Event) -> None:
    if event is Request.RUN:
        machine.run(1, "there", False)
    elif event is Happening.GONE:
        machine.gone(0)
    elif event is Happening.PUSHED:
        if Happening.PUSHED in taken(machine.robot.state) and not machine.covered():
            machine.pushed(1)
    elif isinstance(event, Happening):
        machine.fault("e-stop" if event is Happening.ESTOP else "mistake", 1)
    else:
        getattr(machine, event.value)(1)
