"""The card that heals the robot: a question first, what is being done, and what came of it."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from deltactl.firmware_py.controller.contract import Status
from deltactl.firmware_py.controller.states import State
from deltactl.foundation.errors import DeltactlError, NotReady
from deltactl.repair.heal_answer import KEPT
from deltactl.web.style import marked, tell_problem
from deltactl.web.visit import Visit, offer, why_not

TITLE = "Heal: the robot corrects itself"
SAYS = (
    "It records a survey, is diagnosed and corrected, and draws a heart before and after. The"
    " correction is kept only if the sensors show that it helps."
)
ASK = (
    "The robot moves through its whole range for several minutes: is nobody near it? STOP ends it,"
    " and the old robot file stays in force."
)
UNDONE = "The robot file from before the correction is in force again."
FITTING = (State.OFF, State.UNHOMED, State.READY)
"""States in which a healing may begin."""


class HealCard:
    """For operators, while a robot with distance sensors runs."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._seen: tuple[object, ...] | None = None
        self._status: Status | None = None
        with ui.card().classes("w-full p-3 gap-1").props("data-testid=heal-card") as self.card:
            ui.label(TITLE).classes("font-bold")
            ui.label(SAYS).classes("text-sm text-gray-600")
            with ui.row().classes("gap-2") as self._buttons:
                self._begin = marked(self._button("Heal", "healing", self._ask), "heal")
                self._report = marked(
                    self._button("The whole report", "article", self._read).props("flat"),
                    "heal-report",
                )
                self._undo = marked(
                    self._button("Undo", "undo", self._take_back).props("flat"), "heal-undo"
                )
            self._asked = ui.column().classes("w-full gap-1")
            with ui.row().classes("w-full items-center gap-2 no-wrap") as self._busy:
                ui.spinner(size="sm")
                self._progress = marked(ui.label().classes("text-sm"), "heal-progress")
            self._problem = marked(ui.label().classes("text-red-800"), "heal-problem")
            self._lines = marked(ui.column().classes("gap-0 w-full overflow-x-auto"), "heal-answer")

    def update(self, status: Status | None) -> None:
        """Follow the healing, which another page may have begun."""
        self._status = status
        self.card.set_visibility(status is not None and bool(status.sensors))
        if status is None:
            return
        healings = self._visit.site.healings
        progress, problem = healings.progress, healings.problem
        if self._progress.text != progress:
            self._progress.set_text(progress)
        seen = (bool(progress), problem, status.state, status.robot_path)
        if seen == self._seen:
            return
        self._seen = seen
        self._busy.set_visibility(bool(progress))
        self._problem.set_text(problem)
        self._problem.set_visibility(bool(problem))
        answer = None if progress else healings.answer(status)
        self._begin.set_text("Go on with healing" if problem and answer is None else "Heal")
        busy = "Heal: a healing is under way" if progress else ""
        offer(self._begin, busy or why_not("Heal", FITTING, status.state))
        self._report.set_visibility(answer is not None and healings.report(status).is_file())
        healed = answer is not None and answer["outcome"] in KEPT
        self._undo.set_visibility(healed)
        offer(self._undo, why_not("Undo", (State.UNHOMED, State.READY), status.state))
        self._lines.clear()
        if answer is not None:
            with self._lines:
                for line in answer["lines"]:
                    ui.label(line).classes("text-xs font-mono whitespace-pre-wrap")

    def _button(self, text: str, icon: str, call: Any) -> Any:
        return ui.button(text, icon=icon, on_click=call).props("no-caps dense")

    def _ask(self) -> None:
        """Nothing moves before somebody has said that it may."""
        self._asked.clear()
        with self._asked:
            ui.label(ASK).classes("text-sm")
            with ui.row().classes("gap-2"):
                yes = ui.button("Heal now", icon="play_arrow", on_click=self._begun)
                marked(yes.props("no-caps dense color=red-8").classes("px-2"), "heal-now")
                ui.button("Not now", on_click=self._asked.clear).props("no-caps dense flat")

    async def _begun(self) -> None:
        self._asked.clear()
        status = self._status

        def fits() -> None:
            if status is None or (why := why_not("Heal", FITTING, status.state)):
                raise NotReady(why if status is not None else "no daemon answers")

        if await self._visit.act("heal", fits) is None or status is None:
            return
        try:
            self._visit.site.healings.begin(status)
        except DeltactlError as error:
            tell_problem(str(error))
        self._seen = None

    async def _take_back(self) -> None:
        status = self._status
        if status is not None:
            done = await self._visit.act("undo", self._visit.site.healings.undo, status)
            if done is not None:
                ui.notify(UNDONE, type="positive")
            self._seen = None

    def _read(self) -> None:
        if self._status is not None:
            report = self._visit.site.healings.report(self._status)
            ui.navigate.to(f"/made/{self._visit.site.key_of(report)}", new_tab=True)
