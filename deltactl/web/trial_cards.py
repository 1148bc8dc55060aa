"""Cards to try a robot: one with a corrected file, one with a hidden fault."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nicegui import events, ui

from deltactl.firmware_py.controller.contract import Status
from deltactl.firmware_py.controller.states import ALLOWED, Request, State
from deltactl.web.behind.known_robots import KnownRobot
from deltactl.web.behind.site import NOTHING, SURPRISE, HiddenFault
from deltactl.web.visit import Visit, offer, why_not

SAYS = (
    "The robot runs with a corrected file, of the diagnosis of {found_in}. Run the same job again,"
    " and the diagnosis on the tab Recordings offers to compare both."
)
BACK = "Back: home with {before}"


class TrialCard:
    """Seen only while a corrected file is in force."""

    def __init__(self, visit: Visit):
        self._visit = visit
        self._seen: tuple[str, str] | None = None
        with ui.card().classes("w-full p-3 gap-1").props("data-testid=trial") as self.card:
            self._says = ui.label().classes("text-base")
            if visit.operates:
                self._back = ui.button(icon="undo", on_click=self._end)
                self._back.props("no-caps dense data-testid=trial-back").classes("px-2")
        self.card.set_visibility(False)

    def update(self, status: Status | None) -> None:
        """Follow what is in force."""
        tried = None if status is None else self._visit.site.trial.of(status)
        seen = ("", "") if tried is None or status is None else (tried.in_force, status.state)
        if seen == self._seen:
            return
        self._seen = seen
        self.card.set_visibility(tried is not None)
        if tried is None:
            return
        self._says.set_text(SAYS.format(found_in=tried.found_in))
        if self._visit.operates:
            text = BACK.format(before=Path(tried.before).name)
            self._back.set_text(text)
            offer(self._back, why_not(text, ALLOWED[Request.HOME], seen[1]))

    async def _end(self) -> None:
        seen = await self._visit.act("home", self._visit.site.trial.end)
        if seen is not None:
            self._visit.tell_home(seen)


TITLE = "Try a diagnosis: hide a fault"
LABEL = "Hidden fault of the simulated robot"
THEN = (
    "Switch the robot on, press Home, run heart.yaml on the tab Jobs, and press Diagnose on the tab"
    " Recordings. The diagnosis has the recording and the robot file, and never sees this choice."
)
AT_REST = (State.OFF, State.UNHOMED)
"""States from which homing puts the arms against their stops."""


class HiddenFaultCard:
    """A choice, and the answer to a surprise."""

    def __init__(self, visit: Visit, hidden_fault: HiddenFault):
        self._visit, self._hidden_fault = visit, hidden_fault
        self._known: KnownRobot | None = None
        with ui.card().classes("hidden-fault w-full p-3 gap-1") as self.card:
            ui.label(TITLE).classes("font-bold")
            self._choice = ui.select(hidden_fault.choices, label=LABEL, value=hidden_fault.chosen)
            self._choice.on_value_change(self._chosen)
            self._choice.classes("w-full").props("data-testid=hidden-fault")
            self._why = ui.label().classes("text-sm text-gray-600")
            self._why.props("data-testid=hidden-fault-why")
            self._tell = ui.button("Tell me what it was", icon="visibility", on_click=self._told)
            self._tell.props("no-caps dense flat data-testid=hidden-fault-tell")

    def update(self, known: KnownRobot | None, state: str) -> None:
        """Follow the robot's state, and what was chosen on another page."""
        self._known = known
        self.card.set_visibility(known is not None and known.robot.sensors is not None)
        why = why_not("Another choice", AT_REST, state)
        self._set(self._choice, not why)
        if self._choice.value != self._hidden_fault.chosen:
            self._choice.set_value(self._hidden_fault.chosen)
        text = why or (THEN if self._hidden_fault.chosen != NOTHING else "")
        if self._why.text != text:
            self._why.set_text(text)
        self._tell.set_visibility(self._hidden_fault.chosen == SURPRISE)

    def _chosen(self, event: events.ValueChangeEventArguments[Any]) -> None:
        choice, status = str(event.value), self._visit.site.link.seen.status
        if choice == self._hidden_fault.chosen or self._known is None or status is None:
            return
        if choice in self._hidden_fault.choices and State(status.state) in AT_REST:
            self._hidden_fault.hide(choice, self._known.robot)

    def _told(self) -> None:
        ui.notify(f"Hidden: {self._hidden_fault.really}", type="info", timeout=8_000)

    @staticmethod
    def _set(part: Any, enabled: bool) -> None:
        if part.enabled != enabled:
            part.set_enabled(enabled)
