"""Says that a job has ended, and leads to its recording."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from deltactl.firmware_py.controller.contract import Status
from deltactl.web.motion_card import BY_HAND_JOBS
from deltactl.web.visit import Visit

ENDED = "{job} has ended: its recording is {recording}."


class EndedCard:
    """Seen from the end of a job to the beginning of the next."""

    def __init__(self, visit: Visit):
        self._ran: tuple[str, str] | None = None
        with ui.row().classes("w-full items-center gap-2") as self._row:
            self._says = ui.label().classes("text-sm").props("data-testid=ended")
            show = ui.button("Report and diagnosis", icon="troubleshoot")
            show.on_click(lambda: visit.show_tab("Recordings"))
            show.props("no-caps dense outline data-testid=show-recording").classes("px-2")
        self._row.set_visibility(False)

    def update(self, status: Status) -> None:
        """Follow the job; moves by hand are in no list of recordings."""
        if status.job is not None:
            ran = (status.job, Path(status.recording or "").stem)
            if ran != self._ran:
                self._ran = ran
                self._row.set_visibility(False)
        elif self._ran is not None:
            job, recording = self._ran
            self._ran = None
            self._says.set_text(ENDED.format(job=job, recording=recording))
            self._row.set_visibility(bool(recording) and job not in BY_HAND_JOBS)
