"""The console: the daemon's log as it grows, and how jobs ended."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from nicegui import run, ui

from deltactl.foundation.errors import DeltactlError
from deltactl.web.style import attribute
from deltactl.web.visit import Visit

LOOK_S = 1.0
SHOWN = 300
LEVELS = {"all": "Everything", "warning": "Warnings and errors"}
SEVERE = ("warning", "error", "critical")
NONE_YET = "Nothing is logged yet. Every request, and each stop and fault, is a line here."


class ConsoleTab:
    """Asks for new lines while it is looked at."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._last = 0
        self._lines: list[dict[str, Any]] = []
        self._asking = False
        with ui.card().classes("w-full p-3 gap-2"):
            with ui.row().classes("w-full items-center gap-3"):
                ui.label("Log of the daemon").classes("font-bold grow")
                self._level = ui.toggle(LEVELS, value="all").props("dense no-caps")
                self._level.on_value_change(self._write)
            self._problem = ui.label(NONE_YET).classes("text-sm text-gray-600")
            self._box = ui.column().classes("console w-full gap-0").props("data-testid=log")
        ui.timer(LOOK_S, self.look)

    async def look(self) -> None:
        """Fetch what is new."""
        if self._visit.tab != "Console" or self._asking:
            return
        self._asking = True
        try:
            lines = await run.io_bound(self._visit.site.log, self._last)
        except DeltactlError as error:
            self._problem.set_text(str(error))
            self._last = 0
            return
        finally:
            self._asking = False
        if not lines:
            return
        began_anew = lines[0]["number"] <= self._last
        self._lines = ([] if began_anew else self._lines) + lines
        self._lines = self._lines[-SHOWN:]
        self._last = lines[-1]["number"]
        self._write()

    def _write(self) -> None:
        """The newest first: nobody has to scroll for what has just happened."""
        chosen = [
            line for line in self._lines if self._level.value == "all" or line["level"] in SEVERE
        ]
        self._problem.set_text("" if chosen else NONE_YET)
        self._box.clear()
        with self._box:
            for line in reversed(chosen):
                when = datetime.fromtimestamp(line["time_s"])
                text = f"{when:%H:%M:%S} {line['text']}"
                attribute(ui.label(text).classes("log-line"), "data-level", line["level"])
