"""What fits the robot's state: buttons that cannot be pressed say why, and what to do next."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from deltactl.firmware_py.controller.contract import Status
from deltactl.firmware_py.controller.states import State, said
from deltactl.web.attributes import attribute

GREY = "color=grey-4 text-color=grey-8"
"""Of a button that cannot be pressed: Quasar only makes it a little paler."""


NEXT = {
    "off": "Switch the robot on.",
    "unhomed": "Put the arms against their stops, then press Home.",
    "homing": "Homing: wait, or cancel.",
    "ready": "Ready: choose a job on the tab Jobs, or move by hand.",
    "planning": "A job is checked, or is about to begin: wait, pause, or cancel.",
    "running": "A job runs.",
    "paused": "Paused: resume, or cancel.",
    "stopped": "Stopped: clear the cause, acknowledge above, then home.",
    "fault": "Fault: clear the cause, acknowledge above, then home.",
}
"""What a new user does next."""

SIMULATED = "Press Home: it puts the simulated arms against their stops."
"""Nobody has hands at the simulated robot."""


def what_next(status: Status) -> str:
    """What a new user does next, in one sentence."""
    no_hands = status.simulated and status.state == "unhomed"
    return SIMULATED if no_hands else NEXT.get(status.state, "")


def why_not(what: str, fitting: Collection[State], state: str) -> str:
    """Why something cannot be done now; empty when it can. No `state`: no daemon answers."""
    if not state:
        return f"{what}: not now, no daemon answers"
    now = State(state)
    if now in fitting:
        return ""
    names = " or ".join(said(known) for known in State if known in fitting)
    return f"{what}: not now, the robot is {said(now)}; possible when it is {names}"


def offer(button: Any, why: str) -> None:
    """Switch a button on, or off for a reason that its tooltip and screen readers tell."""
    button.set_enabled(not why)
    if why:
        attribute(button, "title", why).props(GREY)
    else:
        button.props("color=primary", remove="title text-color")
