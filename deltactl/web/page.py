"""One open page: header with the stop button, and three tabs."""

from __future__ import annotations

import logging
from collections.abc import Callable
from datetime import datetime
from typing import Any

from nicegui import run, ui

from deltactl.firmware_py.controller.contract import HomeSeen
from deltactl.fleet.checks import read_announced
from deltactl.foundation.errors import DeltactlError
from deltactl.web.access.sessions import Session, asking, operates
from deltactl.web.attributes import attribute, tell_problem
from deltactl.web.behind.link import STALE_S, Seen
from deltactl.web.behind.site import Site
from deltactl.web.files_tab import FilesTab
from deltactl.web.motion_card import MotionCard
from deltactl.web.recordings.recordings_tab import RecordingsTab
from deltactl.web.scripts import TURNED, WEBGL
from deltactl.web.state_card import StateCard
from deltactl.web.style import DARK, PAPER, STYLE

REFRESH_S = 0.08
ANNOUNCE_S = 3.0
COLOURS = {
    "off": "grey-7",
    "unhomed": "orange-10",
    "homing": "orange-10",
    "ready": "green-8",
    "planning": "teal-8",
    "running": "blue-8",
    "paused": "indigo-6",
    "stopped": "red-8",
    "fault": "red-8",
}
_log = logging.getLogger(__name__)
LATCHED = ("stopped", "fault")


class RobotPage:
    """Built for every browser that opens the page, for the session that does."""

    def __init__(self, site: Site, session: Session):
        self.site = site
        self._serial = -1
        self._shown: tuple[object, ...] = ()
        ui.colors(primary="#1d4ed8")
        ui.dark_mode(None)
        ui.add_css(STYLE + DARK + PAPER)
        ui.add_head_html(WEBGL)
        self._header(session)
        self._stop_button()
        self._small_name = ui.label("deltactl").classes("w-full lt-sm text-base font-bold px-1")
        self._small_name.props("data-testid=small-name")
        self._latch()
        self._tabs.on_value_change(lambda: ui.run_javascript(TURNED))
        with ui.tab_panels(self._tabs, value="Robot", animated=False, keep_alive=True).classes(
            "w-full"
        ):
            with ui.tab_panel("Robot").classes("p-2"):
                self._state = StateCard(self)
            with ui.tab_panel("Jobs").classes("p-2"):
                self._files = FilesTab(self)
            with ui.tab_panel("Recordings").classes("p-2"):
                self._recordings = RecordingsTab(self)
        self._timer = ui.timer(REFRESH_S, self._refresh)
        self._announce()
        ui.timer(ANNOUNCE_S, self._announce)

    @property
    def operates(self) -> bool:
        """Whether whoever asks now may command the robot: the session is looked up each time."""
        return operates()

    def blame(self, components: list[str], found_in: str) -> None:
        """Colour the parts that a diagnosis names, and turn to the robot."""
        self._state.blame(components, found_in)
        self.show_tab("Robot")

    def show_tab(self, name: str) -> None:
        """Turn to another tab."""
        self._tabs.set_value(name)

    def edit(self, name: str, text: str, says: str = "") -> None:
        """Show a job in the editor, from where it can be checked and run."""
        self._files.load(name, text, says)
        self.show_tab("Jobs")

    def motion(self) -> MotionCard | None:
        """The card for moving by hand; operators have it."""
        return self._state.motion

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

    def _header(self, session: Session) -> None:
        with ui.header().classes("items-center py-1 px-2 gap-2 bg-slate-800 no-wrap"):
            self._name = ui.label("deltactl").classes("text-base font-bold ellipsis gt-xs")
            self._chip = ui.badge("...").classes("text-sm px-2 py-1").props("data-testid=state")
            with ui.tabs().props("dense no-caps shrink") as self._tabs:
                first = ui.tab("Robot")
                ui.tab("Jobs")
                ui.tab("Recordings")
            self._tabs.set_value(first)
            ui.space()
            if session.name:
                with ui.element("form").props('method=post action="/logout"'):
                    ui.button(f"{session.name} ({session.role})").props(
                        'type=submit flat dense no-caps color=white aria-label="Sign out"'
                    ).tooltip("sign out")
            ui.element("div").classes("stop-room")

    def _stop_button(self) -> None:
        # Above everything; Quasar draws dialogs at 6000, and what it tells at 9500.
        button = ui.button("STOP", icon="front_hand", on_click=self.stop)
        button.props('color=red-8 text-color=white unelevated aria-label="Emergency stop"')
        button.classes("stop-button").props("data-testid=stop")

    def _latch(self) -> None:
        with ui.row().classes("latch w-full items-center justify-between") as self._latched:
            self._why = ui.label().classes("text-base").props("data-testid=latched")
            if self.operates:
                ui.button(
                    "Cause is gone: acknowledge", icon="lock_open",
                    on_click=lambda: self.ask("acknowledge"),
                ).props("color=white text-color=red-9 no-caps data-testid=acknowledge")  # fmt: skip
        self._latched.set_visibility(False)
        self._news = ui.label().classes("news w-full").props("data-testid=news")
        self._news.set_visibility(False)

    def _announce(self) -> None:
        """What `deltactl check-runs` found to be new since some run."""
        status = self.site.link.seen.status
        found = [one for one in read_announced(self.site.recordings)
                 if status is None or one.robot == status.robot]  # fmt: skip
        text = "; ".join(
            f"{one.says}, since {datetime.fromtimestamp(one.since_s):%d %b %H:%M}"
            f" (probability {one.probability:.2f})"
            for one in found
        )
        if self._news.text != text:
            self._news.set_text(f"New mismatch: {text}" if text else "")
        self._news.set_visibility(bool(text))

    def _refresh(self) -> None:
        seen = self.site.link.seen
        if seen.serial == self._serial and seen.age_s < STALE_S:
            return
        self._serial = seen.serial
        self._show_state(seen)
        if self._tabs.value == "Robot":
            self._state.update(seen)

    def _show_state(self, seen: Seen) -> None:
        status = seen.status
        if status is None:
            shown: tuple[object, ...] = ("no daemon", "grey-7", "", "deltactl")
        else:
            old = f", {seen.age_s:.0f} s old" if seen.age_s > STALE_S else ""
            name = f"{status.robot} (simulated)" if status.simulated else status.robot
            colour = COLOURS.get(status.state, "grey-7")
            why = f"{status.state.upper()}: {status.why or 'no reason given'}"
            latched = why if status.state in LATCHED else ""
            shown = (status.state + old, colour, latched, name)
        if shown == self._shown:
            return
        self._shown = shown
        chip, colour, latched, name = (str(part) for part in shown)
        self._chip.set_text(chip)
        attribute(self._chip, "color", colour)
        self._name.set_text(name)
        self._small_name.set_text(name)
        self._why.set_text(latched)
        self._latched.set_visibility(bool(latched))


def _whose() -> str:
    """Who asks now, for the log and the reason of a stop."""
    session = asking()
    if session is None:
        return "a session that has ended"
    return session.name or "somebody on this machine"
