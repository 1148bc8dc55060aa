"""How jobs ended: when, how long they took, and how far the platform was from its targets."""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path
from typing import Any

from nicegui import ui

from deltactl.firmware_py.controller.states import ENGAGED, State
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.plain_file import write_whole
from deltactl.web.behind.history import Ended
from deltactl.web.visit import Visit

LOOK_S = 3.0
SHOWN = 25
MEASURED, TRUE = "measured", "simulated truth"
HEADS = ("Job", "When", "How it ended", "Duration", "Error")
BY_SENSORS = "Error: root mean square distance from the targets, by the sensors with their noise."


class HistoryCard:
    """A table that follows the history; errors are worked out one after another, at rest."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._shown: list[Ended] = []
        self._errors: dict[str, Any] = {}
        self._labels: dict[str, Any] = {}
        self._working = False
        with ui.card().classes("w-full p-3 gap-1"):
            ui.label("History").classes("font-bold")
            self._grid = (
                ui.element("div")
                .classes("history figures w-full text-sm")
                .props("data-testid=history")
            )
            ui.label(BY_SENSORS).classes("text-xs text-gray-600")
        self._look_at(visit.site.history.newest_first()[:SHOWN])
        ui.timer(LOOK_S, self.look)

    async def look(self) -> None:
        """Follow the history while it is looked at."""
        if self._visit.tab != "Jobs":
            return
        ended = self._visit.site.history.newest_first()[:SHOWN]
        if ended != self._shown:
            self._look_at(ended)
        await self._work_out()

    def _look_at(self, ended: list[Ended]) -> None:
        self._shown = ended
        self._labels = {}
        self._grid.clear()
        with self._grid:
            for head in HEADS:
                ui.label(head).classes("text-gray-600")
            for one in ended:
                when = datetime.fromtimestamp(one.began_s)
                how = f"{one.outcome}: {one.why}" if one.why else one.warning or one.outcome
                for text in (one.name, f"{when:%d %b %H:%M}", how, f"{one.duration_s:.1f} s"):
                    ui.label(text)
                self._labels[one.recording] = ui.label(self._said(one.recording))

    def _said(self, recording: str) -> str:
        """The error of a run, as far as it is known."""
        errors = self._errors.get(recording) if recording else None
        if errors is None:
            return "-"
        sizes = errors.get("errors_m", {})
        size_m = sizes.get(MEASURED, sizes.get(TRUE))
        return "-" if size_m is None else f"{1e3 * size_m:.2f} mm"

    async def _work_out(self) -> None:
        """Work out the next missing error while the robot is idle."""
        status = self._visit.site.link.seen.status
        busy = status is not None and State(status.state) in ENGAGED
        if self._working or busy:
            return
        for one in self._shown:
            if one.recording and one.recording not in self._errors:
                self._working = True
                try:
                    self._errors[one.recording] = await self._errors_of(one.recording)
                finally:
                    self._working = False
                self._labels[one.recording].set_text(self._said(one.recording))
                return

    async def _errors_of(self, recording: str) -> Any:
        path = self._visit.site.recordings / recording
        kept = self._visit.site.work / "made" / Path(recording).stem / "errors.json"
        try:
            if not kept.is_file():
                found = await self._visit.site.tasks.run("errors", path)
                kept.parent.mkdir(parents=True, exist_ok=True)
                write_whole(kept, json.dumps(found))
            return json.loads(kept.read_text(encoding="utf-8"))
        except (DeltactlError, OSError, ValueError):
            return {}
