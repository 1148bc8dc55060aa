"""One open page: header with the stop button, and four tabs."""

from __future__ import annotations

from nicegui import ui

from deltactl.fleet.checks import read_announced
from deltactl.web.access.users import Session
from deltactl.web.behind.link import STALE_S, Seen
from deltactl.web.behind.site import Site
from deltactl.web.console_tab import ConsoleTab
from deltactl.web.files_tab import FilesTab
from deltactl.web.recordings_tab import RecordingsTab
from deltactl.web.state_card import StateCard
from deltactl.web.style import APP, DARK, PAPER, STYLE, TURNED, WEBGL, attribute, painted
from deltactl.web.user_menu import UserMenu
from deltactl.web.visit import Visit

REFRESH_S = 0.1
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
LATCHED = ("stopped", "fault")


class RobotPage:
    """Built for every browser that opens the page, for the session that does."""

    def __init__(self, site: Site, session: Session):
        self._serial = -1
        self._shown: tuple[object, ...] = ()
        ui.colors(primary="#1d4ed8")
        ui.dark_mode(None)
        ui.add_css(STYLE + DARK + PAPER)
        ui.add_head_html(WEBGL + APP)
        self._header(site, session)
        self._visit = visit = Visit(site, self._tabs)
        self._stop_button()
        self._small_name = ui.label("deltactl").classes("w-full lt-sm text-base font-bold px-1")
        self._small_name.props("data-testid=small-name")
        self._latch()
        self._tabs.on_value_change(lambda: ui.run_javascript(TURNED))
        with ui.tab_panels(self._tabs, value="Robot", animated=False, keep_alive=True).classes(
            "w-full"
        ):
            with ui.tab_panel("Robot").classes("p-2"):
                self._state = StateCard(visit)
            with ui.tab_panel("Jobs").classes("p-2"):
                self._files = FilesTab(visit)
            with ui.tab_panel("Recordings").classes("p-2"):
                RecordingsTab(visit)
            with ui.tab_panel("Console").classes("p-2"):
                ConsoleTab(visit)
        visit.lead_to(self._state.blame, self._files.load)
        ui.timer(REFRESH_S, self._refresh)
        self._announce()
        ui.timer(ANNOUNCE_S, self._announce)

    def _header(self, site: Site, session: Session) -> None:
        with ui.header().classes("items-center py-1 px-2 gap-2 bg-slate-800 no-wrap"):
            self._name = ui.label("deltactl").classes("text-base font-bold ellipsis gt-xs")
            self._chip = ui.badge("...").classes("text-sm px-2 py-1").props("data-testid=state")
            with ui.tabs().props("dense no-caps shrink") as self._tabs:
                first = ui.tab("Robot")
                ui.tab("Jobs")
                ui.tab("Recordings")
                ui.tab("Console")
            self._tabs.set_value(first)
            ui.space()
            if session.name:
                UserMenu(session, site.tokens)
            ui.element("div").classes("stop-room")

    def _stop_button(self) -> None:
        # Above everything; Quasar draws dialogs at 6000, and what it tells at 9500.
        button = ui.button("STOP", icon="front_hand", on_click=self._visit.stop)
        button.props('color=red-8 text-color=white unelevated aria-label="Emergency stop"')
        button.classes("stop-button").props("data-testid=stop")

    def _latch(self) -> None:
        with ui.row().classes("latch w-full items-center justify-between") as self._latched:
            self._why = ui.label().classes("text-base").props("data-testid=latched")
            if self._visit.operates:
                ui.button(
                    "Cause is gone: acknowledge",
                    icon="lock_open",
                    on_click=lambda: self._visit.ask("acknowledge"),
                ).props("color=white text-color=red-9 no-caps data-testid=acknowledge")
        self._latched.set_visibility(False)
        self._news = ui.label().classes("news w-full").props("data-testid=news")
        self._news.set_visibility(False)

    def _announce(self) -> None:
        """What `deltactl service check-runs` found to be new since some run."""
        status = self._visit.site.link.seen.status
        text = "; ".join(
            mismatch.told("%d %b %H:%M")
            for mismatch in read_announced(self._visit.site.recordings)
            if status is None or mismatch.robot == status.robot
        )
        if self._news.text != text:
            self._news.set_text(f"New finding: {text}" if text else "")
        self._news.set_visibility(bool(text))

    async def _refresh(self) -> None:
        seen = self._visit.site.link.seen
        if seen.serial == self._serial and seen.age_s < STALE_S:
            return
        self._serial = seen.serial
        self._show_state(seen)
        if self._tabs.value == "Robot":
            self._state.update(seen)
            await painted()

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
