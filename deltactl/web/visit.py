"""What fits the robot's state: buttons that cannot be pressed say why, and what to do next."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection
from typing import Any

from nicegui import run, ui

from deltactl.firmware_py.controller.contract import HomeSeen, Status
from deltactl.firmware_py.controller.states import State, said
from deltactl.foundation.errors import DeltactlError
from deltactl.web.access.users import asking, operates
from deltactl.web.behind.site import Site
from deltactl.web.style import attribute, tell_problem

GREY = "color=off text-color=off-text"
"""Colours of a disabled button, which Quasar only makes a little paler. They are the page's own, as
Quasar's are the same in the dark, and no style can change them."""


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


LOOKS = "The robot is {state}. You are signed in to look and to stop; operators do the rest."


def what_next(status: Status, operates: bool = True) -> str:
    """What a new user does next, in one sentence."""
    if not operates:
        return LOOKS.format(state=said(State(status.state)))
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


_log = logging.getLogger(__name__)


class Visit:
    """What every part of an open page is given."""

    def __init__(self, site: Site, tabs: ui.tabs):
        self.site = site
        self.show_tab = tabs.set_value
        self._tabs = tabs
        self._blame: Callable[[list[str], str], None] | None = None
        self._edit: Callable[[str, str, str], None] | None = None

    @property
    def tab(self) -> str:
        """The tab that is looked at."""
        return str(self._tabs.value)

    @property
    def operates(self) -> bool:
        """Whether whoever asks now may command the robot: the session is looked up each time."""
        return operates()

    def lead_to(
        self, blame: Callable[[list[str], str], None], edit: Callable[[str, str, str], None]
    ) -> None:
        """blame: what colours parts of the drawing; edit: what puts a job into the editor."""
        self._blame, self._edit = blame, edit

    def blame(self, components: list[str], found_in: str) -> None:
        """Colour the parts that a diagnosis names, and turn to the robot."""
        if self._blame is not None:
            self._blame(components, found_in)
        self.show_tab("Robot")

    def edit(self, name: str, text: str, says: str = "") -> None:
        """Show a job in the editor, from where it can be checked and run."""
        if self._edit is not None:
            self._edit(name, text, says)
        self.show_tab("Jobs")

    async def act(self, name: str, call: Callable[..., Any], *arguments: Any) -> Any:
        """Ask the daemon something; what it refuses is shown in one line. None when refused."""
        if not self.operates:
            ui.notify(f"cannot {name}: you are signed in to look, not to operate", type="warning")
            return None
        _log.info("%s asked for by %s", name, _whose())
        try:
            answer = await run.io_bound(call, *arguments)
        except DeltactlError as error:
            tell_problem(str(error))
            return None
        return True if answer is None else answer

    async def ask(self, name: str) -> Any:
        """A request without arguments, by its name in the client."""

        def call() -> None:
            with self.site.link.client() as client:
                getattr(client, name)()

        return await self.act(name.replace("_", " "), call)

    def tell_home(self, seen: HomeSeen) -> None:
        """What the sensors said at home, and whether somebody should look."""
        kind: Any = "warning" if seen.warning else "positive"
        ui.notify(seen.says(), type=kind, multi_line=True, timeout=8_000)

    async def stop(self) -> None:
        """Emergency stop; everybody who sees the page may."""
        _log.info("stop asked for by %s", _whose())
        session = asking()
        by = f" by {session.name}" if session is not None and session.name else ""
        try:
            await run.io_bound(self.site.link.stop, f"stopped on the page{by}")
        except DeltactlError as error:
            tell_problem(f"NOT STOPPED: {error}")


def _whose() -> str:
    """Who asks now, for the log and the reason of a stop."""
    session = asking()
    if session is None:
        return "a session that has ended"
    return session.name or "somebody on this machine"
