"""What a robot does on each request, in each state: one table, which the controller consults.

Every change of state is one of its rows (`Condition.take` and `Condition.go`); the page
docs/reference/states.md is made from it, and a test walks it with two clients.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from deltactl.foundation.errors import NotReady


class State(enum.Enum):
    """What the robot is doing. STOPPED and FAULT are latched until acknowledged."""

    OFF = "off"
    UNHOMED = "unhomed"
    HOMING = "homing"
    READY = "ready"
    PLANNING = "planning"
    """A job is accepted and checked, or is about to begin; the arms are at rest."""
    RUNNING = "running"
    PAUSED = "paused"
    """A job holds on its path, or has not begun and is held."""
    STOPPED = "stopped"
    FAULT = "fault"


class Request(enum.Enum):
    """What a user may ask for."""

    ON = "on"
    OFF = "off"
    HOME = "home"
    RUN = "run"
    PAUSE = "pause"
    RESUME = "resume"
    CANCEL = "cancel"
    STOP = "stop"
    ACKNOWLEDGE = "acknowledge"


class Happening(enum.Enum):
    """What changes the state without being asked for."""

    HOMED = "the homing succeeds"
    NOT_HOMED = "the homing fails"
    BEGUN = "the next job begins"
    ENDED = "a job ends, or is refused by its check"
    WAITS = "a job comes to a pause of its own"
    GONE = "a client with a job or homing disconnects"
    PUSHED = "an arm moves at rest"
    TRIED = "a client with a robot file on trial disconnects, and nothing moves"
    ESTOP = "the e-stop is pressed"
    FAULT = "a fault is detected"


Event = Request | Happening


class Ends(enum.Flag):
    """Which accepted requests an event calls off."""

    NOTHING = 0
    HOMING = enum.auto()
    WAITING = enum.auto()
    """Jobs that are planned or queued."""
    RUNNING = enum.auto()
    ALL = HOMING | WAITING | RUNNING


class Moves(enum.Enum):
    """What may still move once an event is answered."""

    NOTHING = "nothing"
    HOMING = "the homing"
    LAST_OF_HOMING = "the homing, for 0.1 s at most"
    JOBS = "accepted jobs"
    SLOWING = "the running job, until it has stopped"


LAST_OF_HOMING_S: Final = 0.1
"""So far ahead of time is a homing queued, which is what LAST_OF_HOMING says."""


@dataclass(frozen=True, slots=True)
class Rule:
    """What an event does in a state.

    then: states that may follow; more than one where it depends on which jobs are left.
    ends: accepted requests that are called off with the answer.
    """

    then: tuple[State, ...]
    moves: Moves = Moves.NOTHING
    ends: Ends = Ends.NOTHING


_S = State
_OFF_AGAIN = Rule((_S.OFF,))
_HALTED = Rule((_S.STOPPED,), ends=Ends.ALL)
_FAULTED = Rule((_S.FAULT,), ends=Ends.ALL)
_HOMING = Rule((_S.HOMING,), Moves.HOMING)
_HOMING_ENDS = Rule((_S.UNHOMED,), Moves.LAST_OF_HOMING, Ends.HOMING)
_JOBS_END = Ends.WAITING | Ends.RUNNING
_ALIVE = (_S.OFF, _S.UNHOMED, _S.HOMING, _S.READY, _S.PLANNING, _S.RUNNING, _S.PAUSED)

TABLE: Final[Mapping[Event, Mapping[State, Rule]]] = {
    Request.ON: {_S.OFF: Rule((_S.UNHOMED,))},
    Request.OFF: {
        _S.OFF: _OFF_AGAIN,
        _S.UNHOMED: _OFF_AGAIN,
        _S.HOMING: Rule((_S.OFF,), ends=Ends.HOMING),
        _S.READY: _OFF_AGAIN,
        _S.PLANNING: Rule((_S.OFF,), ends=Ends.WAITING),
        _S.STOPPED: Rule((_S.STOPPED,)),
        _S.FAULT: Rule((_S.FAULT,)),
    },
    Request.HOME: {_S.UNHOMED: _HOMING, _S.READY: _HOMING},
    Request.RUN: {
        _S.READY: Rule((_S.PLANNING,), Moves.JOBS),
        _S.PLANNING: Rule((_S.PLANNING,), Moves.JOBS),
        _S.RUNNING: Rule((_S.RUNNING,), Moves.JOBS),
        _S.PAUSED: Rule((_S.PAUSED,)),
    },
    Request.PAUSE: {
        _S.PLANNING: Rule((_S.PAUSED,)),
        # One that was cancelled and still slows down is shown as running; what follows is held.
        _S.RUNNING: Rule((_S.PAUSED, _S.RUNNING), Moves.SLOWING),
    },
    Request.RESUME: {_S.PAUSED: Rule((_S.RUNNING, _S.PLANNING), Moves.JOBS)},
    Request.CANCEL: {
        _S.HOMING: _HOMING_ENDS,
        _S.PLANNING: Rule((_S.READY, _S.PLANNING), ends=Ends.WAITING),
        _S.RUNNING: Rule((_S.RUNNING,), Moves.SLOWING, _JOBS_END),
        _S.PAUSED: Rule((_S.RUNNING, _S.READY, _S.PAUSED), Moves.SLOWING, _JOBS_END),
    },
    Request.STOP: {
        **dict.fromkeys(_ALIVE, _HALTED),
        _S.STOPPED: Rule((_S.STOPPED,)),
        _S.FAULT: Rule((_S.FAULT,)),
    },
    Request.ACKNOWLEDGE: {
        _S.STOPPED: Rule((_S.UNHOMED,)),
        _S.FAULT: Rule((_S.UNHOMED,)),
    },
    Happening.HOMED: {_S.HOMING: Rule((_S.READY,))},
    Happening.NOT_HOMED: {_S.HOMING: _HOMING_ENDS},
    Happening.BEGUN: {_S.PLANNING: Rule((_S.RUNNING,), Moves.JOBS)},
    Happening.ENDED: {
        _S.PLANNING: Rule((_S.READY, _S.PLANNING), Moves.JOBS),
        _S.RUNNING: Rule((_S.READY, _S.PLANNING, _S.PAUSED, _S.RUNNING), Moves.JOBS),
        _S.PAUSED: Rule((_S.READY, _S.PAUSED)),
    },
    Happening.WAITS: {_S.RUNNING: Rule((_S.PAUSED,))},
    Happening.GONE: {
        _S.HOMING: _HOMING_ENDS,
        _S.PLANNING: Rule((_S.READY, _S.PLANNING), Moves.JOBS, Ends.WAITING),
        _S.RUNNING: Rule((_S.RUNNING,), Moves.JOBS, _JOBS_END),
        _S.PAUSED: Rule((_S.READY, _S.PAUSED, _S.RUNNING), Moves.SLOWING, _JOBS_END),
    },
    Happening.PUSHED: {
        _S.READY: Rule((_S.UNHOMED,)),
        _S.PLANNING: Rule((_S.UNHOMED,), ends=Ends.WAITING),
        _S.PAUSED: Rule((_S.UNHOMED,), ends=Ends.WAITING),
    },
    Happening.TRIED: {
        _S.OFF: _OFF_AGAIN,
        _S.UNHOMED: Rule((_S.UNHOMED,)),
        _S.READY: Rule((_S.UNHOMED,)),
        _S.STOPPED: Rule((_S.STOPPED,)),
        _S.FAULT: Rule((_S.FAULT,)),
    },
    Happening.ESTOP: dict.fromkeys(_ALIVE, _HALTED),
    Happening.FAULT: dict.fromkeys(_ALIVE, _FAULTED),
}
"""An event that has no rule in a state is refused there, where it is a request.

GONE calls off what belongs to that client and nothing else; a `cancel` with a number one job.
"""

ALLOWED: Final[dict[Request, frozenset[State]]] = {
    request: frozenset(TABLE[request]) for request in Request
}
"""In which states a request is taken."""

ENGAGED: Final = frozenset({State.HOMING, State.PLANNING, State.RUNNING, State.PAUSED})
"""A request that was accepted may move, now or soon."""

CLEAR = "clear the cause, "
BY_HAND = "put the arms against their stops, "
"""Nobody has hands near the simulated robot, which does it by itself as it homes."""
WAY_OUT: dict[State, str] = {
    State.OFF: "'deltactl power on', {by_hand}'deltactl home'",
    State.UNHOMED: "{by_hand}'deltactl home'",
    State.HOMING: "wait, or use 'deltactl job cancel' or 'deltactl stop'",
    State.READY: "start a job with 'deltactl run JOB.yaml'",
    State.PLANNING: "wait, or use 'deltactl job pause' or 'deltactl job cancel'",
    State.RUNNING: "wait, or use 'deltactl job pause' or 'deltactl job cancel'",
    State.PAUSED: "use 'deltactl job resume' or 'deltactl job cancel'",
    State.STOPPED: "{clear}'deltactl acknowledge', {by_hand}'deltactl home'",
    State.FAULT: "{clear}'deltactl acknowledge', {by_hand}'deltactl home'",
}
"""What to do, in order, to get on; wherever something is refused, and after a stop."""


def way_out(state: State, simulated: bool = False) -> str:
    """The line of WAY_OUT for a robot."""
    by_hand, clear = ("", "") if simulated else (BY_HAND, CLEAR)
    return WAY_OUT[state].format(by_hand=by_hand, clear=clear)


SAID: dict[State, str] = {State.FAULT: "in a fault", State.PLANNING: "planning a job"}
"""How a state is said in a sentence, where its name is no word for that."""


def said(state: State) -> str:
    """A state after 'the robot is'."""
    return SAID.get(state, state.value)


IN_WORDS: dict[Request, str] = {Request.ON: "switch on", Request.OFF: "switch off"}


def require(request: Request, state: State, why: str = "", simulated: bool = False) -> Rule:
    """The rule; raises NotReady, saying what to do, when `request` is not allowed in `state`."""
    rule = TABLE[request].get(state)
    if rule is None:
        cause = f" ({why})" if why else ""
        wish = IN_WORDS.get(request, request.value)
        way = way_out(state, simulated)
        raise NotReady(f"cannot {wish}: the robot is {said(state)}{cause}; {way}")
    return rule
