"""Jobs and robot files: choose or paste one, check it, run it."""

from __future__ import annotations

from typing import Any

from nicegui import events, run, ui

from deltactl.firmware_py.controller.states import ALLOWED, Request
from deltactl.foundation.errors import DeltactlError
from deltactl.web.behind.own_jobs import MAX_CHARACTERS
from deltactl.web.behind.own_recordings import plain_name
from deltactl.web.behind.texts import Marked, kind_of, mistakes, of_another_robot
from deltactl.web.history_card import HistoryCard
from deltactl.web.own_jobs_list import OwnJobsList
from deltactl.web.plots import preview_options
from deltactl.web.style import PICK_JOB
from deltactl.web.visit import Visit, what_next, why_not

FACTS: tuple[tuple[str, str, str, float], ...] = (
    ("duration_s", "duration", "s", 1.0),
    ("targets", "targets", "", 1.0),
    ("path_length_m", "path length", "mm", 1e3),
    ("mean_speed_mps", "mean speed", "mm/s", 1e3),
    ("smallest_margin", "singularity margin", "", 1.0),
)
"""Columns of a dry run's figures: key, name, unit, factor."""
MEANT = {
    "smallest_margin": "1 is well away from poses in which the arms cannot hold or steer the"
    " platform (all stretched, or all flat), 0 is there; less than the robot file's"
    " limits.singularity_margin is refused"
}
"""Figures that are not their own explanation."""
SIMULATE = ". To see that robot here, start this page with: deltactl web --simulate --robot {name}"


SAID = {
    None: "text-base",
    True: "text-base text-green-800",
    False: "text-base text-red-800",
}
"""How a verdict looks: none yet, good, bad."""


JUDGE_S = 0.3


class FilesTab:
    """A list, an editor, what can be done with it, and how jobs ended."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._texts: dict[str, str] = {}
        """What was opened here, by name: of no file of the project."""
        files = visit.site.files()
        self._name = visit.site.first_file
        self._resting = ""
        with ui.row().classes("w-full gap-3"):
            with ui.card().classes("grow basis-96 min-w-0 max-w-full p-3 gap-2"):
                self._choice = ui.select(list(files), label="Job or robot file", value=self._name)
                self._choice.on_value_change(self._chosen)
                self._choice.classes("w-full").props("data-testid=file")
                with ui.row().classes("w-full gap-2 items-center"):
                    if visit.operates:
                        go = ui.button("Run", icon="play_arrow", on_click=self.run)
                        go.props("no-caps size=lg color=green-8").classes("px-6")
                        go.props("data-testid=run")
                    check = ui.button("Check", icon="rule", on_click=self.check)
                    check.props("no-caps outline").props("data-testid=check")
                    ui.space()
                    self._upload()
                self._spinner = ui.spinner(size="md")
                self._spinner.set_visibility(False)
                self._verdict = ui.label().classes("text-base").props("data-testid=verdict")
                self._mistakes = ui.column().classes("gap-0 w-full").props("data-testid=mistakes")
                self._facts = ui.column().classes("gap-0 figures text-sm")
                self._preview = (
                    ui.element("div").classes("w-full overflow-hidden").props("data-testid=preview")
                )
                self._chart: ui.echart | None = None
                self._mine = OwnJobsList(visit, lambda: (self._name, self._text_now()), self._open)
            with ui.card().classes("grow basis-96 min-w-0 p-3"):
                text = files[self._name].read_text(encoding="utf-8")
                self._text = ui.codemirror(text, language="YAML", line_wrapping=True)
                self._text.on_value_change(self._typed)
                self._text.classes("w-full editor").props("data-testid=text")
        HistoryCard(visit)
        self._judged = text
        ui.timer(JUDGE_S, self._judge)

    async def _open(self, name: str, text: str) -> None:
        """Show a job of one's own, and where it goes."""
        self.load(name, text)
        await self.check()

    def _text_now(self) -> str:
        return self._text.value or ""

    def _typed(self) -> None:
        self._say("")

    async def _judge(self) -> None:
        """Look at what was typed, once it has rested for a moment."""
        text = self._text_now()
        if text == self._judged:
            return
        if text != self._resting:
            self._resting = text
            return
        self._judged = text
        self._mark(await run.io_bound(mistakes, text, self._name) or [])

    def _mark(self, found: list[Marked]) -> None:
        """Each mistake as a line of text, and its line in the editor marked."""
        last = self._text_now().count("\n") + 1
        lines = {one.line: one.says for one in reversed(found) if 1 <= one.line <= last}
        self._text.decorations = [
            {"kind": "line", "line": line, "class": "mistake"} for line in lines
        ]
        self._text.line_tooltips = lines
        self._mistakes.clear()
        with self._mistakes:
            for one in found:
                where = f"line {one.line}: " if one.line else ""
                ui.label(f"{where}{one.says}").classes("text-sm text-red-800")

    def _upload(self) -> None:
        """A small button before the uploader, which is as large as a card and stays hidden."""
        self._uploader = ui.upload(auto_upload=True, max_file_size=MAX_CHARACTERS)
        self._uploader.on_upload(self._uploaded)
        self._uploader.on_rejected(lambda: ui.notify("a file may have 60 kB", type="negative"))
        self._uploader.props("accept=.yaml,.yml").classes("hidden job-upload")
        button = ui.button("Open a file of yours", icon="upload_file").props("no-caps flat dense")
        button.props("data-testid=upload")
        button.on("click", js_handler=PICK_JOB)

    async def check(self) -> bool:
        """A dry run of what the editor holds; nothing moves."""
        text, name = self._text.value or "", self._name
        self._say("checking ...")
        self._spinner.set_visibility(True)
        try:
            kind = kind_of(text)
            another = of_another_robot(self._visit.site, name, text) if kind == "job" else ""
            if another:
                self._say(another, good=False)
                return False
            draft = self._visit.site.draft(text)
            try:
                facts = await self._visit.site.tasks.run(f"check_{kind}", draft)
            except DeltactlError as error:
                raise type(error)(str(error).replace(str(draft), name)) from error
            finally:
                self._visit.site.forget(draft)
        except DeltactlError as error:
            if self._holds(text):
                self._say(str(error), good=False)
            return False
        finally:
            self._spinner.set_visibility(False)
        if not self._holds(text):
            return False
        after = ", and may run." if kind == "job" else SIMULATE.format(name=name)
        self._say(f"{name} is a {kind} file without mistakes{after}", good=True)
        self._list(facts)
        self._draw(facts.get("path_m", []))
        return kind == "job"

    def _holds(self, text: str) -> bool:
        """Whether the editor still holds what was checked: another file may be there by now."""
        return (self._text.value or "") == text

    async def run(self) -> None:
        """Check, then send it to the daemon, which checks again."""
        text, name = self._text.value or "", self._name
        status = self._visit.site.link.seen.status
        if why := why_not("Run", ALLOWED[Request.RUN], status.state if status else ""):
            next_ = what_next(status) if status else ""
            self._say(f"{why}. On the tab Robot: {next_}", good=False)
            return
        if not await self.check():
            return

        def call() -> int:
            return self._visit.site.link.submit_text(text, name)

        number = await self._visit.act("run", call)
        if number is None:
            self._say("not run", good=False)
        else:
            self._say(f"{name} is job {number}: follow it on the tab Robot.", good=True)
            self._visit.show_tab("Robot")

    def load(self, name: str, text: str, says: str = "") -> None:
        """Put a text into the editor, and its name where one is chosen."""
        self._name = name
        self._texts[name] = text
        if name not in self._choice.options:
            self._choice.set_options([name, *self._choice.options])
        self._choice.set_value(name)
        self._text.set_value(text)
        self._say(says, good=True)

    async def _chosen(self, event: events.ValueChangeEventArguments[Any]) -> None:
        name = str(event.value)
        if name == self._name:
            return
        path = self._visit.site.files().get(name)
        if name in self._texts:
            self.load(name, self._texts[name])
        elif path is not None:
            self._name = name
            self._text.set_value(path.read_text(encoding="utf-8"))
            await self.check()

    async def _uploaded(self, event: events.UploadEventArguments) -> None:
        raw = await event.file.read()
        self._uploader.reset()
        try:
            text = raw[: MAX_CHARACTERS + 1].decode("utf-8")
        except UnicodeDecodeError:
            self._say("that is not a text file in UTF-8", good=False)
            return
        self.load(plain_name(event.file.name, "unnamed.yaml"), text)

    def _say(self, text: str, good: bool | None = None) -> None:
        self._verdict.set_text(text)
        self._verdict.classes(replace=SAID[good])
        self._facts.clear()
        self._preview.set_visibility(False)

    def _draw(self, paths_m: list[list[list[float]]]) -> None:
        """Where the job goes, from above and from the side."""
        if not any(paths_m):
            return
        # A chart that is removed before the browser has its library fails there, so it is kept.
        if self._chart is None:
            with self._preview:
                self._chart = ui.echart({}).classes("w-full preview")
        self._chart.options.clear()
        self._chart.options.update(preview_options(paths_m))
        self._chart.update()
        self._preview.set_visibility(True)

    def _list(self, facts: dict[str, Any]) -> None:
        with self._facts:
            for key, name, unit, factor in FACTS:
                if isinstance(value := facts.get(key), int | float):
                    ui.label(f"{name}: {value * factor:.4g} {unit}".rstrip())
                    if key in MEANT:
                        ui.label(MEANT[key]).classes("text-xs text-gray-600 pl-4 max-w-md")
            if "arm_range_deg" in facts:
                ranges = ", ".join(
                    f"{low:.1f} to {high:.1f}" for low, high in facts["arm_range_deg"]
                )
                ui.label(f"arm angles: {ranges} degrees")
