"""What each column of somebody's table is, and in which unit: guessed, and then chosen."""

from __future__ import annotations

from collections import Counter
from collections.abc import Awaitable, Callable
from typing import Any

from nicegui import ui

from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.plain_file import write_whole
from deltactl.web.behind.own_recordings import AS_IT_IS, Chosen, chosen_beside, mapping_text
from deltactl.web.behind.shelf import Listed
from deltactl.web.style import labelled
from deltactl.web.visit import Visit

NOT_USED = "not used"
SAYS = "What is each column, and in which unit? Guessed where headings and values tell."
TWICE = "{name} is chosen for two columns: choose one"


class ColumnsForm:
    """Closed until it is asked for."""

    def __init__(self, visit: Visit, listed: Listed, diagnose: Callable[[], Awaitable[None]]):
        """diagnose: what is done with a choice."""
        self._visit, self._listed, self._diagnose = visit, listed, diagnose
        self._found: dict[str, Any] = {}
        self._fields: list[tuple[str, Any, Any]] = []
        self._box = ui.column().classes("gap-1 w-full").props("data-testid=columns-form")

    async def open(self) -> None:
        """Look at the table, and offer what was guessed."""
        self._box.clear()
        try:
            self._found = await self._visit.site.tasks.run("inspect", self._listed.path)
        except DeltactlError as error:
            with self._box:
                ui.label(self._listed.shown(str(error))).classes("text-red-800 text-sm")
            return
        with self._box:
            self._write()

    def _write(self) -> None:
        ui.label(SAYS).classes("text-sm")
        for warning in self._found["warnings"]:
            ui.label(warning).classes("text-sm text-gray-600")
        self._fields = [self._field(column) for column in self._found["columns"]]
        with ui.row().classes("gap-2"):
            go = ui.button("Diagnose with these columns", icon="troubleshoot", on_click=self._done)
            go.props("no-caps dense data-testid=columns-done").classes("px-2")
            close = ui.button("Close", on_click=self._box.clear)
            close.props("no-caps dense flat")

    def _field(self, column: dict[str, str]) -> tuple[str, Any, Any]:
        units_of: dict[str, list[str]] = self._found["units_of"]
        names = {"": NOT_USED} | {name: name for name in units_of}
        with ui.row().classes("items-center gap-3 w-full"):
            ui.label(f"{column['column']} ({column['first']} ...)").classes("text-sm w-56 ellipsis")
            name = ui.select(names, label="is", value=column["name"]).classes("w-36")
            unit = ui.select(
                _units(units_of.get(column["name"], [])), label="in", value=column["unit"]
            ).classes("w-28")
        labelled(name.props("dense"), f"what {column['column']} is")
        labelled(unit.props("dense"), f"unit of {column['column']}")

        def changed() -> None:
            known = _units(units_of.get(str(name.value), []))
            unit.set_options(known, value=unit.value if unit.value in known else AS_IT_IS)

        name.on_value_change(changed)
        return column["column"], name, unit

    async def _done(self) -> None:
        chosen = [
            Chosen(column, str(name.value), str(unit.value)) for column, name, unit in self._fields
        ]
        counted = Counter(choice.name for choice in chosen if choice.name)
        if twice := next((name for name, count in counted.items() if count > 1), ""):
            ui.notify(TWICE.format(name=twice), type="warning")
            return
        text = mapping_text(self._found["mapping"], chosen)
        write_whole(chosen_beside(self._listed.path), text)
        self._box.clear()
        await self._diagnose()


def _units(known: list[str]) -> dict[str, str]:
    """As options: the first is that nothing is to be converted."""
    return {AS_IT_IS: "as it is"} | {unit: unit for unit in known if unit != AS_IT_IS}
