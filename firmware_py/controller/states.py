"""The states of a robot and which request is allowed in which: one table."""

from __future__ import annotations

import enum

from deltactl.foundation.errors import NotReady


class State(enum.Enum):
    """What the robot is doing. STOPPED and FAULT are latched until acknowledged."""

    OFF = "off"
    UNHOMED = "unhomed"
    READY = "ready"
    RUNNING = "running"
    PAUSED = "paused"
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


ALLOWED: dict[Request, frozenset[State]] = {
    Request.ON: frozenset({State.OFF}),
    Request.OFF: frozenset({State.UNHOMED, State.READY, State.STOPPED, State.FAULT}),
    Request.HOME: frozenset({State.UNHOMED, State.READY}),
    Request.RUN: frozenset({State.READY, State.RUNNING, State.PAUSED}),
    Request.PAUSE: frozenset({State.RUNNING}),
    Request.RESUME: frozenset({State.PAUSED}),
    Request.CANCEL: frozenset({State.RUNNING, State.PAUSED}),
    Request.STOP: frozenset(State),
    Request.ACKNOWLEDGE: frozenset({State.STOPPED, State.FAULT}),
}

CLEAR = "clear the cause, "
BY_HAND = "put the arms against their stops, "
"""Nobody has hands near the simulated robot, which does it by itself as it homes."""
WAY_OUT: dict[State, str] = {
    State.OFF: "'deltactl on', {by_hand}'deltactl home'",
    State.UNHOMED: "{by_hand}'deltactl home'",
    State.READY: "start a job with 'deltactl run JOB.yaml'",
    State.RUNNING: "wait, or use 'deltactl pause' or 'deltactl cancel'",
    State.PAUSED: "use 'deltactl resume' or 'deltactl cancel'",
    State.STOPPED: "{clear}'deltactl acknowledge', {by_hand}'deltactl home'",
    State.FAULT: "{clear}'deltactl acknowledge', {by_hand}'deltactl home'",
}
"""What to do, in order, to get on; wherever something is refused, and after a stop."""


def way_out(state: State, simulated: bool = False) -> str:
    """The line of WAY_OUT for a robot."""
    by_hand, clear = ("", "") if simulated else (BY_HAND, CLEAR)
    return WAY_OUT[state].format(by_hand=by_hand, clear=clear)


SAID: dict[State, str] = {State.FAULT: "in a fault"}
"""How a state is said in a sentence, where its name is no word for that."""


def said(state: State) -> str:
    """A state after 'the robot is'."""
    return SAID.get(state, state.value)


IN_WORDS: dict[Request, str] = {Request.ON: "switch on", Request.OFF: "switch off"}


def require(request: Request, state: State, why: str = "", simulated: bool = False) -> None:
    """Raise NotReady, saying what to do, when `request` is not allowed in `state`."""
    if state not in ALLOWED[request]:
        cause = f" ({why})" if why else ""
        wish = IN_WORDS.get(request, request.value)
        way = way_out(state, simulated)
        raise NotReady(f"cannot {wish}: the robot is {said(state)}{cause}; {way}")
