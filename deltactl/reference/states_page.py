"""The page of the robot's behaviour: its table of states and requests, in words."""

from __future__ import annotations

from deltactl.firmware_py.controller.states import (
    TABLE,
    Ends,
    Event,
    Happening,
    Moves,
    Request,
    Rule,
    State,
    way_out,
)

STATE_WORDS: dict[State, str] = {
    State.OFF: "The drives are released.",
    State.UNHOMED: "The drives hold the arms; their angles are not known.",
    State.HOMING: "The arms are being homed.",
    State.READY: "Homed; no job is accepted.",
    State.PLANNING: "A job is checked and planned, or is about to begin. The arms are at rest.",
    State.RUNNING: "A job runs, or slows down because it was called off.",
    State.PAUSED: "A job holds on its path, or has not begun and is held.",
    State.STOPPED: "Somebody stopped the robot. Latched until acknowledged.",
    State.FAULT: "The robot stopped by itself. Latched until acknowledged.",
}
ENDS_WORDS: dict[Ends, str] = {
    Ends.HOMING: "the homing",
    Ends.WAITING: "planned and queued jobs",
    Ends.RUNNING: "the running job",
}
PRESENT: dict[Ends, tuple[State, ...]] = {
    Ends.HOMING: (State.HOMING,),
    Ends.WAITING: (State.PLANNING, State.RUNNING, State.PAUSED),
    Ends.RUNNING: (State.RUNNING, State.PAUSED),
}
"""In which states there is something of the kind to call off."""
Row = tuple[str, ...]


def states() -> list[Row]:
    """One row for each state: its meaning, and how to leave it."""
    return [
        (f"`{state.value}`", STATE_WORDS[state], way_out(state).replace("'", "`"))
        for state in State
    ]


def overview() -> list[Row]:
    """Events down, states across: what follows; empty where nothing does."""
    events: list[Event] = [*Request, *Happening]
    return [
        (_name(event), *(_then(TABLE[event].get(state)) for state in State)) for event in events
    ]


def consequences() -> list[Row]:
    """Rows of events after which something is called off or may move; alike events share one."""
    events: list[Event] = [*Request, *Happening]
    rows: dict[tuple[str, str], tuple[list[str], Ends]] = {}
    for event in events:
        for state, rule in TABLE[event].items():
            present = Ends.NOTHING
            for kind, states in PRESENT.items():
                present |= kind if kind in rule.ends and state in states else Ends.NOTHING
            if present or rule.moves is not Moves.NOTHING:
                at, ends = rows.get((_name(event), rule.moves.value), ([], Ends.NOTHING))
                rows[_name(event), rule.moves.value] = ([*at, state.value], ends | present)
    alike: dict[Row, list[str]] = {}
    for (name, moves), (at, ends) in rows.items():
        called_off = ", ".join(ENDS_WORDS[kind] for kind in ENDS_WORDS if kind in ends)
        alike.setdefault((", ".join(at), called_off, moves), []).append(name)
    return [("; ".join(names), *row) for row, names in alike.items()]


def _name(event: Event) -> str:
    return f"`{event.value}`" if isinstance(event, Request) else event.value


def _then(rule: Rule | None) -> str:
    return "" if rule is None else " or ".join(state.value for state in rule.then)


INTRODUCTION = (
    "What the robot does on each request in each state. The controller reads the same table "
    "(`TABLE` in `firmware_py/controller/states.py`), and "
    "`tests/daemon/test_every_request_in_every_state.py` tries every row."
)
RULES = (
    "Where several states may follow, the jobs that are left decide: `running` if one runs, "
    "`paused` if one is held, `planning` if one is planned or queued, else `ready`.",
    "An answered request is in force. What an event calls off never moves afterwards, except as "
    "the last table shows. A client that waits for it gets the reason, and the result "
    "`cancelled`, `stopped` or `fault`.",
    "`home` is answered once the robot is homed, `run` with the number of the job once it is "
    "checked.",
    "A job and a homing belong to the connection that asked for them, and end with it; "
    "jobs of other clients go on. `run` with "
    "`detach` outlives its connection once it is answered.",
    "`stop`, `off`, and `cancel` without a `job_id` also refuse earlier commands of all clients "
    "that have not begun. `cancel` with a `job_id` calls off that job alone.",
    "Unless a job reaches its own end, its outputs go to their safe levels.",
)
COLUMNS = ("event", "in", "called off", "may still move")
