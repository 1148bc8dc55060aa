"""Recordings: their reports, a diagnosis at a click, and what follows from it."""

from __future__ import annotations

import contextlib
import json
import re
import time
from collections.abc import Collection
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import ui

from foundation.errors import DeltactlError
from web.behind.site import Listed
from web.behind.whose_job import same_machine
from web.offers import offer
from web.own_recording import OwnRecording

if TYPE_CHECKING:
    from web.page import RobotPage

LOOK_S = 3.0
INTRODUCTION = (
    "Runs of this robot, newest first. A diagnosis compares a run with its robot file. "
    "A table of your own is compared with the file of the robot that is shown here; "
    "for other machines: deltactl diagnose data.csv --inspect"
)
REASONS = "Why, how surely, and what to do next"
CORRECTED = (
    "corrected.yaml compensates what was found: try it with deltactl run JOB.yaml"
    " --robot corrected.yaml"
)
RECORDED = "still being recorded; possible when the run has ended"
VERDICTS = {
    "nothing_missing": ("nothing is missing", "green-8"),
    "explained": ("explained", "orange-10"),
    "partly_explained": ("partly explained", "deep-orange-10"),
    "unexplained": ("unexplained", "red-8"),
}


class RecordingsTab:
    """A list that follows the folder."""

    def __init__(self, page: RobotPage):
        self._page = page
        self._rows: dict[str, RecordingRow] = {}
        ui.label(INTRODUCTION).classes("text-sm text-gray-600")
        if page.operates:
            with ui.row().classes("items-center gap-2"):
                OwnRecording(self._look)
        self._empty = ui.label("No recording yet: run a job.").classes("text-base")
        self._list = ui.column().classes("w-full gap-2")
        self._look()
        ui.timer(LOOK_S, self._look)

    def _look(self) -> None:
        """Add and remove rows; one that stays keeps its answer and a diagnosis under way."""
        found = {one.path.name: one for one in self._page.site.listed()}
        for name in self._rows.keys() - found.keys():
            self._rows.pop(name).card.delete()
        with self._list:
            for name, one in found.items():
                if name not in self._rows:
                    self._rows[name] = RecordingRow(self._page, one)
        for place, name in enumerate(found):
            row = self._rows[name]
            row.look(found[name])
            if self._list.default_slot.children[place] is not row.card:
                row.card.move(target_index=place)
        self._empty.set_visibility(not found)


class RecordingRow:
    """One recording."""

    def __init__(self, page: RobotPage, listed: Listed):
        self._page, self._listed = page, listed
        self._seen_s = 0.0
        self._open = False
        with ui.card().classes("w-full p-2 gap-1") as self.card:
            with ui.row().classes("w-full items-center gap-2"):
                ui.label(listed.title).classes("font-bold grow ellipsis").props(
                    "data-testid=recording"
                )
                self._when = ui.label().classes("text-sm")
                self._read = ui.button("Report", icon="show_chart", on_click=self.report)
                self._read.props("no-caps dense outline").classes("px-2")
                self._read.props("data-testid=report")
                self._read.set_visibility(listed.path.suffix == ".mcap")
                self._button = ui.button("Diagnose", icon="troubleshoot", on_click=self.diagnose)
                self._button.props("no-caps dense").classes("px-2").props("data-testid=diagnose")
            self._progress = ui.row().classes("items-center gap-2")
            self._written = ui.row()
            self._answer = ui.column().classes("gap-1 w-full")

    def look(self, listed: Listed) -> None:
        """Follow the file, and what was answered about it, also to another page."""
        self._listed = listed
        when = datetime.fromtimestamp(listed.written_s)
        text = f"{when:%d %b %H:%M}, {listed.size_bytes / 1e6:.1f} MB"
        self._lock(self._page.site.grows(listed.path))
        if self._when.text != text:
            self._when.set_text(text)
        answered_s = listed.answered_s
        if answered_s > self._seen_s and (answer := listed.diagnosis) is not None:
            self._seen_s = answered_s
            self._answer.clear()
            self._show(answer)

    def _lock(self, grows: bool) -> None:
        """What is not whole yet can be neither shown nor diagnosed."""
        if grows == self._open:
            return
        self._open = grows
        for what, button in (("Report", self._read), ("Diagnose", self._button)):
            offer(button, f"{what}: {RECORDED}" if grows else "")

    async def report(self) -> None:
        """Write the report of the run, if there is none, and open it.

        A browser keeps a page from opening another one seconds after a press: where writing takes
        longer than that, a link that can be pressed is all there is.
        """
        out = self._listed.made / "run.html"
        self._listed.made.mkdir(parents=True, exist_ok=True)
        if not out.is_file():
            await self._work("writing the report", "run_report", self._listed.path, out)
        if out.is_file():
            url = self._url("run.html")
            self._written.clear()
            with self._written:
                link = ui.link("Open the report of the run", url, new_tab=True)
                link.classes("text-sm").props("data-testid=run-report")
            ui.navigate.to(url, new_tab=True)

    async def diagnose(self) -> None:
        """Diagnose it, and keep the answer."""
        made = self._listed.made
        made.mkdir(parents=True, exist_ok=True)
        self._button.set_enabled(False)
        try:
            files = (self._listed.path, made, *self._by())
            answer = await self._work("diagnosing", "diagnose", *files)
        finally:
            self._button.set_enabled(True)
        if answer is not None:
            (made / "diagnosis.json").write_text(json.dumps(answer), encoding="utf-8")
            self.look(self._listed)

    def _by(self) -> list[Path]:
        """The robot file for a table; a recorded run carries its own."""
        robot = self._page.site.robot_file()
        return [robot] if robot is not None and self._listed.path.suffix != ".mcap" else []

    async def _work(self, what: str, kind: str, *files: Any) -> dict[str, Any] | None:
        """A worker with its progress; None when it failed, which is shown."""
        started_s = time.monotonic()
        with self._progress:
            ui.spinner(size="sm")
            line = ui.label(what).props("data-testid=progress")

        def tell(text: str) -> None:
            line.set_text(f"{what}, {time.monotonic() - started_s:.0f} s: {text}")

        try:
            return await self._page.site.tasks.run(kind, *files, progress=tell)
        except DeltactlError as error:
            self._answer.clear()
            with self._answer:
                path, own = self._listed.path, self._listed.own
                says = str(error).replace(str(path), own or path.name)
                ui.label(says).classes("text-red-800").props("data-testid=failed")
            return None
        finally:
            self._progress.clear()

    def _show(self, answer: dict[str, Any]) -> None:
        made = self._listed.made
        text, colour = VERDICTS.get(answer["verdict"], (answer["verdict"], "grey-8"))
        with self._answer:
            ui.badge(text).props(f"color={colour}").classes("text-sm").props("data-testid=answer")
            lines, heads = answer["lines"], answer.get("heads", ())
            at_once = answer.get("at_once", len(lines))
            _write(lines[:at_once], heads)
            if at_once < len(lines):
                with ui.expansion(REASONS).classes("w-full").props("dense") as reasons:
                    _write(lines[at_once + 1 :], heads)
                reasons.props("data-testid=reasons header-class=text-weight-bold")
            with ui.row().classes("gap-2"):
                self._follow("The whole report", "article", self._report)
                if answer["components"]:
                    self._follow("Show it on the robot", "my_location", self._blame)
                if (made / "corrected.yaml").is_file():
                    self._follow("Correct it: save the robot file", "download", self._save)
                if self._page.operates and (made / "next.yaml").is_file():
                    self._follow("The experiment that would tell more", "science", self._next)
            if (made / "corrected.yaml").is_file():
                ui.label(CORRECTED).classes("text-sm text-gray-600")

    def _follow(self, text: str, icon: str, call: Any) -> None:
        ui.button(text, icon=icon, on_click=call).props("no-caps dense flat")

    def _report(self) -> None:
        ui.navigate.to(self._url("report.html"), new_tab=True)

    def _blame(self) -> None:
        answer = self._listed.diagnosis
        if answer and self._page.scene is not None:
            self._page.scene.blame(answer["components"])
            self._page.show_tab("Robot")

    def _save(self) -> None:
        with contextlib.suppress(OSError):
            text = (self._listed.made / "corrected.yaml").read_bytes()
            ui.download.content(text, "corrected.yaml")

    def _next(self) -> None:
        with contextlib.suppress(OSError):
            text = (self._listed.made / "next.yaml").read_text(encoding="utf-8")
            belief = self._page.site.belief(self._page.site.link.seen)
            if belief is not None and same_machine(belief, self._listed.made / "robot.yaml"):
                # The answer knows the robot file of the recording by another name.
                text = re.sub(r"(?m)^robot: .*$", f"robot: {belief.file}", text)
            self._page.edit("next-experiment.yaml", text)

    def _url(self, name: str) -> str:
        return f"/made/{self._page.site.key_of(self._listed.made / name)}"


def _write(lines: list[str], heads: Collection[str]) -> None:
    """Titles bold, and what belongs to one set in."""
    for line in lines:
        label = ui.label(line.strip()).classes("text-sm")
        if line in heads:
            label.classes("font-bold")
        elif line.startswith(" "):
            label.classes("pl-4")
