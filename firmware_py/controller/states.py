"""The states of a robot and which request is allowed in which: one table."""

from __future__ import annotations

import enum

from foundation.errors import NotReady


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

PLACED = "put the arms against their stops (simulated ones by 'deltactl off' and 'deltactl on')"
WAY_OUT: dict[State, str] = {
    State.OFF: "switch it on with 'deltactl on'",
    State.UNHOMED: "put the arms against their stops and run 'deltactl home'",
    State.READY: "start a job with 'deltactl run JOB.yaml'",
    State.RUNNING: "wait, or use 'deltactl pause' or 'deltactl cancel'",
    State.PAUSED: "use 'deltactl resume' or 'deltactl cancel'",
    State.STOPPED: f"clear the cause, then 'deltactl acknowledge', {PLACED}, and 'deltactl home'",
    State.FAULT: f"clear the cause, then 'deltactl acknowledge', {PLACED}, and 'deltactl home'",
}


IN_WORDS: dict[Request, str] = {Request.ON: "switch on", Request.OFF: "switch off"}


def require(request: Request, state: State, why: str = "") -> None:
    """Raise NotReady, saying what to do, when `request` is not allowed in `state`."""
    if state not in ALLOWED[request]:
        cause = f" ({why})" if why else ""
        wish = IN_WORDS.get(request, request.value)
        raise NotReady(f"cannot {wish}: the robot is {state.value}{cause}; {WAY_OUT[state]}")
