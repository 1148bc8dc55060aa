"""Says that the robot runs with a corrected robot file, and leads back."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from deltactl.firmware_py.controller.contract import Status
from deltactl.firmware_py.controller.states import ALLOWED, Request
from deltactl.web.offers import offer, why_not
from deltactl.web.visit import Visit

SAYS = (
    "The robot runs with a corrected file, of the diagnosis of {found_in}. Run the same job again,"
    " and the diagnosis on the tab Recordings offers to compare both."
)
BACK = "Back: home with {before}"


class TrialCard:
    """Seen only while a corrected file is in force."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._seen: tuple[str, str] | None = None
        with ui.card().classes("w-full p-3 gap-1").props("data-testid=trial") as self.card:
            self._says = ui.label().classes("text-base")
            if visit.operates:
                self._back = ui.button(icon="undo", on_click=self._end)
                self._back.props("no-caps dense data-testid=trial-back").classes("px-2")
        self.card.set_visibility(False)

    def update(self, status: Status | None) -> None:
        """Follow what is in force."""
        tried = None if status is None else self._visit.site.trial.of(status)
        seen = ("", "") if tried is None or status is None else (tried.in_force, status.state)
        if seen == self._seen:
            return
        self._seen = seen
        self.card.set_visibility(tried is not None)
        if tried is None:
            return
        self._says.set_text(SAYS.format(found_in=tried.found_in))
        if self._visit.operates:
            text = BACK.format(before=Path(tried.before).name)
            self._back.set_text(text)
            offer(self._back, why_not(text, ALLOWED[Request.HOME], seen[1]))

    async def _end(self) -> None:
        seen = await self._visit.act("home", self._visit.site.trial.end)
        if seen is not None:
            self._visit.tell_home(seen)
