"""The answer of a diagnosis, and what follows from it at a click."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Collection
from typing import Any

from nicegui import ui

from deltactl.firmware_py.controller.contract import HomeSeen
from deltactl.firmware_py.controller.states import ALLOWED, Request
from deltactl.foundation.errors import DeltactlError, NotReady
from deltactl.web.behind.shelf import Listed
from deltactl.web.behind.texts import same_machine
from deltactl.web.style import attribute
from deltactl.web.visit import Visit, what_next, why_not

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


CORRECTED = (
    "The corrected robot file compensates what was found. To try it, the robot is homed with it,"
    "  and uses it until it is homed with another file or its daemon ends."
)
TRY = "Try it: home with the corrected file"
AGAIN = "The robot runs with the corrected file: press Run to see what that changes."
VERDICTS = {
    "nothing_missing": ("nothing is missing", "green-8"),
    "explained": ("explained", "orange-10"),
    "partly_explained": ("partly explained", "deep-orange-10"),
    "unexplained": ("unexplained", "red-8"),
}


class AnswerView:
    """Empty until there is an answer, or a problem to tell."""

    def __init__(self, visit: Visit, listed: Listed):
        self._visit, self._made = visit, listed.made
        self._listed = listed
        self._seen_s = 0.0
        self._box = ui.column().classes("gap-1 w-full")
        self._after = BeforeAndAfter(visit)

    def look(self, listed: Listed, again: Listed | None) -> None:
        """Show the newest answer, also of a diagnosis that another page has asked for.

        again: a later run of the same job.
        """
        self._listed = listed
        self._after.look(listed, again if (self._made / "corrected.yaml").is_file() else None)
        answered_s = listed.answered_s
        if answered_s > self._seen_s and (answer := listed.diagnosis) is not None:
            self._seen_s = answered_s
            self._box.clear()
            with self._box:
                self._show(answer)

    def tell(self, problem: str) -> None:
        """Say why there is no answer."""
        self._box.clear()
        with self._box:
            ui.label(problem).classes("text-red-800").props("data-testid=failed")

    def _show(self, answer: dict[str, Any]) -> None:
        text, colour = VERDICTS.get(answer["verdict"], (answer["verdict"], "grey-8"))
        badge = attribute(ui.badge(text), "color", colour)
        badge.classes("text-sm").props("data-testid=answer")
        lines, heads = answer["lines"], answer.get("heads", ())
        _write(lines, heads)
        corrected = (self._made / "corrected.yaml").is_file()
        with ui.row().classes("gap-2"):
            self._follow("The whole report", "article", self._report)
            if answer["components"]:
                self._follow("Show it on the robot", "my_location", self._blame)
            if corrected and self._visit.operates:
                self._follow(TRY, "build", self._try).props("data-testid=try")
            if corrected:
                self._follow("Correct it: save the robot file", "download", self._save)
            if self._visit.operates and (self._made / "next.yaml").is_file():
                self._follow("The experiment that would tell more", "science", self._next)
        if corrected:
            ui.label(CORRECTED).classes("text-sm text-gray-600")

    def _follow(self, text: str, icon: str, call: Any) -> Any:
        return ui.button(text, icon=icon, on_click=call).props("no-caps dense flat")

    def _report(self) -> None:
        url = f"/made/{self._visit.site.key_of(self._made / 'report.html')}"
        ui.navigate.to(url, new_tab=True)

    def _blame(self) -> None:
        answer = self._listed.diagnosis
        if answer:
            self._visit.blame(answer["components"], self._listed.title)

    def _save(self) -> None:
        with contextlib.suppress(OSError):
            text = (self._made / "corrected.yaml").read_bytes()
            ui.download.content(text, "corrected.yaml")

    async def _try(self) -> None:
        """Home with the corrected file, and put the recorded job where it can be run again."""

        def begin() -> HomeSeen:
            status = self._visit.site.link.seen.status
            if why := why_not("Home", ALLOWED[Request.HOME], status.state if status else ""):
                raise NotReady(f"{why}. On the tab Robot: {what_next(status) if status else ''}")
            text = (self._made / "corrected.yaml").read_text(encoding="utf-8")
            return self._visit.site.trial.begin(text, self._listed.title)

        seen = await self._visit.act("home with the corrected file", begin)
        if seen is None:
            return
        self._visit.tell_home(seen)
        if (self._made / "job.yaml").is_file():
            self._edit("job.yaml", f"{self._listed.job or 'job'}-again.yaml", AGAIN)
        else:
            self._visit.show_tab("Robot")

    def _next(self) -> None:
        self._edit("next.yaml", "next-experiment.yaml")

    def _edit(self, file: str, name: str, says: str = "") -> None:
        """A job that was made of the recordings, for the robot that runs here."""
        with contextlib.suppress(OSError):
            text = (self._made / file).read_text(encoding="utf-8")
            known = self._visit.site.known(self._visit.site.link.seen)
            if known is not None and same_machine(known, self._made / "robot.yaml"):
                # The answer knows the robot file of the recording by another name.
                text = re.sub(r"(?m)^robot: .*$", f"robot: {known.file}", text)
            self._visit.edit(name, text, says)


def _write(lines: list[str], heads: Collection[str]) -> None:
    """A screen of text, its titles bold; a table in it keeps its columns."""
    with ui.column().classes("gap-0 w-full overflow-x-auto").props("data-testid=screen"):
        for line in lines:
            label = ui.label(line or "\u00a0").classes("text-xs font-mono whitespace-pre")
            if line in heads:
                label.classes("font-bold")
