"""Recordings: a list that follows the folder, and several of them diagnosed together."""

from __future__ import annotations

from nicegui import ui

from deltactl.web.offers import offer
from deltactl.web.recordings.own_recording import OwnRecording
from deltactl.web.recordings.recording_row import RecordingRow
from deltactl.web.visit import Visit

LOOK_S = 3.0
INTRODUCTION = (
    "Runs of this robot, newest first. A diagnosis compares a run with its robot file. "
    "A table of your own is compared with the file of the robot that is shown here; Columns says "
    "what its columns are; "
    "for other machines: deltactl diagnose data.csv --inspect"
)
TICK = "Tick two recordings or more of one robot: together they tell more than one motion does."


class RecordingsTab:
    """A list that follows the folder."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._rows: dict[str, RecordingRow] = {}
        self._own: OwnRecording | None = None
        ui.label(INTRODUCTION).classes("text-sm text-gray-600")
        with ui.row().classes("items-center gap-2"):
            if visit.operates:
                self._own = OwnRecording(self._look)
            self._together = ui.button(icon="join_full", on_click=self._diagnose_together)
            self._together.props("no-caps dense data-testid=together").classes("px-2")
        self._empty = ui.label("No recording yet: run a job.").classes("text-base")
        self._list = ui.column().classes("w-full gap-2")
        self._look()
        self._ticked()
        ui.timer(LOOK_S, self._look)

    def _look(self) -> None:
        """Add and remove rows; one that stays keeps its answer and a diagnosis under way."""
        listed = self._visit.site.listed()
        found = {one.made.name: one for one in listed}
        for name in self._rows.keys() - found.keys():
            self._rows.pop(name).card.delete()
        with self._list:
            for name, one in found.items():
                if name not in self._rows:
                    self._rows[name] = RecordingRow(self._visit, one, self._ticked, self._begun)
        for place, name in enumerate(found):
            row = self._rows[name]
            row.look(found[name], found[name].again_in(listed))
            if self._list.default_slot.children[place] is not row.card:
                row.card.move(target_index=place)
        self._empty.set_visibility(not found)

    def _begun(self) -> None:
        if self._own is not None:
            self._own.tell("")

    def _chosen(self) -> list[RecordingRow]:
        return [row for row in self._rows.values() if row.ticked]

    def _ticked(self) -> None:
        chosen = len(self._chosen())
        text = "Tick several to diagnose them together"
        self._together.set_text(f"Diagnose {chosen} together" if chosen > 1 else text)
        offer(self._together, TICK if chosen < 2 else "")

    async def _diagnose_together(self) -> None:
        """Diagnose those that are ticked as recordings of one robot; the answer has its own row."""
        chosen = self._chosen()
        name = self._visit.site.shelf.together([row.listed for row in chosen])
        for row in chosen:
            row.untick()
        self._look()
        await self._rows[name].diagnose()
