"""Recordings: a list that follows the folder; each with its report and a diagnosis at a click."""

from __future__ import annotations

import time
from collections.abc import Awaitable, Callable
from datetime import datetime
from typing import Any

from nicegui import events, ui

from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.printable import file_size
from deltactl.web.answer_view import AnswerView
from deltactl.web.behind.own_recordings import chosen_beside
from deltactl.web.behind.shelf import Listed, file_url
from deltactl.web.columns_form import ColumnsForm
from deltactl.web.manage import Manage
from deltactl.web.playback import Playback
from deltactl.web.style import PICK_RECORDING, SEND, labelled
from deltactl.web.visit import Visit, offer


class OwnRecording:
    """Opens the browser's dialog, and says what became of the file."""

    def __init__(self, taken: Callable[[], None]):
        """taken: called after each file."""
        self._taken = taken
        place = ui.element("input").props('type=file accept=".csv,.gz,.mcap"').classes("hidden")
        place.props("data-testid=own-file")
        place.on("change", js_handler=SEND)
        place.on("message", self._message, args=["detail"])
        button = ui.button("Open a recording of yours", icon="upload_file")
        button.props("no-caps dense outline data-testid=own-recording").classes("px-2")
        button.on("click", js_handler=PICK_RECORDING)
        self._line = ui.label().classes("text-sm").props("data-testid=own-says")

    def tell(self, text: str) -> None:
        """Say something about the newest file."""
        self._line.set_text(text)

    def _message(self, event: events.GenericEventArguments) -> None:
        self.tell(str(event.args.get("detail", ""))[:400])
        self._taken()


COLUMNS = "press Columns, and say what each is"
RECORDED = "still being recorded; possible when the run has ended"


Work = Callable[[Callable[[str], None]], Awaitable[Any]]


class RecordingRow:
    """One recording, or several that are diagnosed together."""

    def __init__(
        self,
        visit: Visit,
        listed: Listed,
        ticked: Callable[[], None],
        begun: Callable[[], None],
    ):
        """ticked: called when the choice of this one changes; begun: when work on it begins."""
        self._begun = begun
        self._visit, self._listed = visit, listed
        self._open = False
        self._tick: Any = None
        with ui.card().classes("recording w-full p-2 gap-1") as self.card:
            with ui.row().classes("w-full items-center gap-2"):
                if not listed.parts:
                    self._tick = ui.checkbox(on_change=ticked).props("dense data-testid=tick")
                    labelled(self._tick, f"choose {listed.title}")
                ui.label(listed.title).classes("font-bold grow ellipsis").props(
                    "data-testid=recording"
                )
                self._when = ui.label().classes("text-sm")
                self._read = ui.button("Report", icon="show_chart", on_click=self.report)
                self._read.props("no-caps dense outline").classes("px-2")
                self._read.props("data-testid=report")
                self._read.set_visibility(not listed.parts and listed.path.suffix == ".mcap")
                self._button = ui.button("Diagnose", icon="troubleshoot", on_click=self.diagnose)
                self._button.props("no-caps dense").classes("px-2").props("data-testid=diagnose")
                if _is_table(listed) and visit.operates:
                    self._offer_columns()
                self._play = ui.button("Play", icon="play_circle", on_click=self.play)
                self._play.props("no-caps dense outline data-testid=play-it").classes("px-2")
                self._play.set_visibility(listed.path.suffix == ".mcap" and not listed.parts)
                whole = not listed.parts
                manage = Manage(
                    listed.title,
                    self._rename if whole and visit.operates else None,
                    self._delete if visit.operates else None,
                    self._download if whole else None,
                )
            manage.below()
            self._playback = Playback(visit, listed)
            self._progress = ui.row().classes("items-center gap-2")
            self._written = ui.row()
            self._columns = ColumnsForm(visit, listed, self.diagnose)
            self._answer = AnswerView(visit, listed)

    def _offer_columns(self) -> None:
        button = ui.button("Columns", icon="view_column", on_click=lambda: self._columns.open())
        button.props("no-caps dense outline data-testid=columns").classes("px-2")

    @property
    def listed(self) -> Listed:
        """What it shows."""
        return self._listed

    @property
    def ticked(self) -> bool:
        """Whether it was chosen to be diagnosed together with others."""
        return self._tick is not None and bool(self._tick.value) and not self._open

    def untick(self) -> None:
        """Take the choice back."""
        if self._tick is not None:
            self._tick.set_value(False)

    def look(self, listed: Listed, again: Listed | None) -> None:
        """Follow the file, and what was answered about it, also to another page.

        again: a later run of its job.
        """
        self._listed = listed
        when = datetime.fromtimestamp(listed.written_s)
        text = f"{when:%d %b %H:%M}, {file_size(listed.size_bytes)}"
        self._lock(any(self._visit.site.grows(single.path) for single in listed.singles))
        if self._when.text != text:
            self._when.set_text(text)
        if again is not None and self._visit.site.grows(again.path):
            again = None
        self._answer.look(listed, again)

    def _lock(self, grows: bool) -> None:
        """What is not whole yet can be neither shown nor diagnosed."""
        if grows == self._open:
            return
        self._open = grows
        for what, button in (
            ("Report", self._read),
            ("Play", self._play),
            ("Diagnose", self._button),
        ):
            offer(button, f"{what}: {RECORDED}" if grows else "")
        if self._tick is not None:
            self._tick.set_enabled(not grows)

    async def report(self) -> None:
        """Write the report of the run, if there is none, and open it.

        A browser keeps a page from opening another one seconds after a press: where writing takes
        longer than that, a link that can be pressed is all there is.
        """
        out = self._listed.made / "run.html"
        self._listed.made.mkdir(parents=True, exist_ok=True)
        if not out.is_file():
            tasks, path = self._visit.site.tasks, self._listed.path
            await self._work(
                "writing the report", lambda tell: tasks.run("run_report", path, out, progress=tell)
            )
        if out.is_file():
            url = f"/made/{self._visit.site.key_of(out)}"
            self._written.clear()
            with self._written:
                link = ui.link("Open the report of the run", url, new_tab=True)
                link.classes("text-sm").props("data-testid=run-report")
            ui.navigate.to(url, new_tab=True)

    async def play(self) -> None:
        """Show the run again, or close it."""
        await self._work("reading the run", lambda _: self._playback.open())

    async def _rename(self, name: str) -> None:
        await self._visit.act("rename", self._visit.site.rename, self._listed, name)

    async def _delete(self) -> None:
        self._playback.close()
        await self._visit.act("delete", self._visit.site.delete, self._listed)

    def _download(self) -> None:
        ui.navigate.to(file_url(self._listed))

    async def diagnose(self) -> None:
        """Diagnose it, and keep the answer."""
        self._button.set_enabled(False)
        try:
            site = self._visit.site
            await self._work("diagnosing", lambda tell: site.diagnose(self._listed, tell), True)
        finally:
            self._button.set_enabled(True)
        self._answer.look(self._listed, None)

    async def _work(self, what: str, work: Work, by_columns: bool = False) -> None:
        """Something long with its progress; what goes wrong is shown.

        by_columns: whether columns of a table that nobody has chosen may be the reason.
        """
        self._begun()
        started_s = time.monotonic()
        with self._progress:
            ui.spinner(size="sm")
            line = ui.label(what).props("data-testid=progress")

        def tell(text: str) -> None:
            line.set_text(f"{what}, {time.monotonic() - started_s:.0f} s: {text}")

        try:
            await work(tell)
        except DeltactlError as error:
            says = str(error)
            if by_columns and any(map(_lacks_a_choice, self._listed.singles)):
                says = f"{says.removesuffix(error.typed)}; {COLUMNS}"
            self._answer.tell(self._listed.shown(says))
        finally:
            self._progress.clear()


def _is_table(listed: Listed) -> bool:
    return bool(listed.own) and listed.path.suffix != ".mcap"


def _lacks_a_choice(listed: Listed) -> bool:
    """Whether nobody has said yet what the columns of a table are."""
    return _is_table(listed) and not chosen_beside(listed.path).is_file()


LOOK_S = 3.0
INTRODUCTION = (
    "Runs of this robot, newest first. A diagnosis compares a run with its robot file. "
    "A table of your own is compared with the file of the robot that is shown here; Columns says "
    "what its columns are; "
    "for other machines: deltactl inspect data.csv"
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
        found = {recording.made.name: recording for recording in listed}
        for name in self._rows.keys() - found.keys():
            self._rows.pop(name).card.delete()
        with self._list:
            for name, recording in found.items():
                if name not in self._rows:
                    self._rows[name] = RecordingRow(
                        self._visit, recording, self._ticked, self._begun
                    )
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
