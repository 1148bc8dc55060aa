"""Two runs of a job side by side: before something was corrected, and after."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from deltactl.foundation.errors import DeltactlError
from deltactl.web.behind.shelf import Listed
from deltactl.web.visit import Visit

OFFER = "Compare with the run of {run}"
SEEN_BY = {
    "simulated truth": "Really (the simulation knows)",
    "measured": "By the sensors, with their noise",
}
"""How far the platform was from where it should have been: what is shown of it."""
ENDED_EARLY = "One of the runs did not come to the end of its path: run the job again to compare."
SAME_FILE = "Both runs were made with the same effects in their robot file."


class BeforeAndAfter:
    """A button once the job was run again, and then a few lines."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._before: Listed | None = None
        self._again: Listed | None = None
        self._box = ui.column().classes("gap-1")

    def look(self, listed: Listed, again: Listed | None) -> None:
        """again: a later run of the job; None where there is nothing to compare."""
        if again == self._again:
            return
        self._before, self._again = listed.singles[-1], again
        self._box.clear()
        if again is None:
            return
        with self._box:
            text = OFFER.format(run=again.title)
            self._button = ui.button(text, icon="compare_arrows", on_click=self._compare)
            self._button.props("no-caps dense outline data-testid=compare").classes("px-2")
            self._lines = ui.column().classes("gap-0").props("data-testid=compared")

    async def _compare(self) -> None:
        if self._before is None or self._again is None:
            return
        before, again = self._before, self._again
        self._button.set_enabled(False)
        try:
            found = await self._visit.site.tasks.run("compare", before.path, again.path)
        except DeltactlError as error:
            found = {"problem": again.shown(before.shown(str(error)))}
        finally:
            self._button.set_enabled(True)
        self._lines.clear()
        with self._lines:
            self._write(found)

    def _write(self, found: dict[str, Any]) -> None:
        if problem := found.get("problem") or ("" if found["whole"] else ENDED_EARLY):
            ui.label(problem).classes("text-red-800")
            return
        ui.label("Distance from the targets (RMS), before and after:").classes("font-bold text-sm")
        for name, says in SEEN_BY.items():
            if name in found["errors_m"]:
                before_mm, after_mm = (1e3 * value for value in found["errors_m"][name])
                ui.label(f"{says}: {before_mm:.2f} mm, then {after_mm:.2f} mm").classes("text-sm")
        if found["same_file"]:
            ui.label(SAME_FILE).classes("text-sm text-gray-600")
