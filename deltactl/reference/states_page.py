"""The page of the robot's behaviour: its table of states and requests, in words."""

from __future__ import annotations

from deltactl.firmware_py.controller.states import (
    TABLE,
    Ends,
    Event,
    Happening,
    Request,
    Rule,
    State,
    way_out,
)

STATE_WORDS: dict[State, str] = {
    State.OFF: "The drives are released.",
    State.UNHOMED: "The drives hold the arms; their angles are not known.",
    State.HOMING: "A `home` is carried out.",
    State.READY: "Homed; no job is accepted.",
    State.PLANNING: "A job is checked and planned, or is about to begin. The arms are at rest.",
    State.RUNNING: "A job runs, or slows down because it was called off.",
    State.PAUSED: "A job holds on its path, or has not begun and is held.",
    State.STOPPED: "Somebody stopped the robot. Latched until acknowledged.",
    State.FAULT: "The robot stopped by itself. Latched until acknowledged.",
}
ENDS_WORDS: dict[Ends, str] = {
    Ends.HOMING: "the homing",
    Ends.WAITING: "jobs that are planned or queued",
    Ends.RUNNING: "the job that runs",
}
PRESENT: dict[Ends, tuple[State, ...]] = {
    Ends.HOMING: (State.HOMING,),
    Ends.WAITING: (State.PLANNING, State.RUNNING, State.PAUSED),
    Ends.RUNNING: (State.RUNNING, State.PAUSED),
}
"""In which states there is something of the kind to call off."""
OWN = {
    Happening.GONE: "only what that client asked for and did not detach",
}
REPLIES = {
    Request.HOME: "what was seen, once homed",
    Request.RUN: "the number of the job, once it is checked",
}
"""Of the others: done."""

Row = tuple[str, ...]


def rows_of(state: State) -> list[Row]:
    """One row for each event that has a rule in a state, requests first."""
    events: list[Event] = [*Request, *Happening]
    return [_row(event, state, TABLE[event][state]) for event in events if state in TABLE[event]]


def refused_in(state: State) -> str:
    """What is refused in a state, and what the refusal says to do."""
    names = [f"`{request.value}`" for request in Request if state not in TABLE[request]]
    return f"Refused: {', '.join(names)}. To get on: {way_out(state).replace('`', '')}."


def overview() -> list[Row]:
    """Requests down, states across: what follows; empty where it is refused."""
    return [
        (f"`{request.value}`", *(_then(TABLE[request].get(state)) for state in State))
        for request in Request
    ]


def _row(event: Event, state: State, rule: Rule) -> Row:
    asked = isinstance(event, Request)
    return (
        f"`{event.value}`" if asked else event.value,
        REPLIES.get(event, "done") if isinstance(event, Request) else "",
        _then(rule),
        _ended(event, state, rule.ends),
        rule.moves.value,
    )


def _then(rule: Rule | None) -> str:
    return "" if rule is None else " or ".join(state.value for state in rule.then)


def _ended(event: Event, state: State, ends: Ends) -> str:
    there = [kind for kind, states in PRESENT.items() if kind in ends and state in states]
    every = ", ".join(ENDS_WORDS[kind] for kind in there)
    own = OWN.get(event, "") if isinstance(event, Happening) else ""
    return f"{every} ({own})" if every and own else every


INTRODUCTION = (
    "What the robot does on each request in each state. The controller consults this very table "
    "(`TABLE` in `firmware_py/controller/states.py`): an event without a row changes nothing, and "
    "a request without one is refused. `tests/daemon/test_every_request_in_every_state.py` tries "
    "every row, and walks the table at random with two clients and faults: no step edge is sent "
    "that no live, accepted request covers."
)
RULES = (
    "Where more than one state may follow, it depends on which jobs are left: one that runs, "
    "`running`; one that is held, `paused`; one that is planned or queued, `planning`; none, "
    "`ready`.",
    "A request that was answered is in force. What an event calls off never moves afterwards, "
    "except as the last column says; whoever waits for its answer is refused with the reason, and "
    "its result is `cancelled`, `stopped` or `fault`.",
    "A job and a homing belong to the connection that asked for them, and end with it. `run` with "
    "`detach` outlives its connection once it was answered.",
    "`stop`, `off`, and `cancel` without a `job_id` also refuse commands of all clients that came "
    "before them and have not begun. `cancel` with a `job_id` calls off that job alone.",
    "However a job ends, but for its own end, its outputs are put to their safe levels.",
)
COLUMNS = ("event", "reply", "next state", "called off", "what may still move")
