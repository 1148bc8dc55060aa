"""What can be done with anything that has a name on the page: rename, delete, download."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from deltactl.web.style import marked, small

Do = Callable[..., Any]


class Manage:
    """Small buttons in a row; what they ask for is answered in the place that they open below."""

    def __init__(self, name: str, rename: Do | None, delete: Do | None, download: Do | None):
        """rename: called with the new name; None where that cannot be done, or not by a viewer."""
        self._name, self._rename, self._delete = name, rename, delete
        self._asked: Any = None
        with ui.row().classes("gap-0 items-center no-wrap"):
            if rename is not None:
                small(f"rename {name}", "edit", self._ask_name, "rename-it")
            if download is not None:
                small(f"download {name}", "download", download, "download-it")
            if delete is not None:
                small(f"delete {name}", "delete", self._ask_twice, "delete-it")

    def below(self) -> None:
        """Where the questions appear: called once, in the place for them."""
        self._asked = ui.row().classes("w-full items-center gap-2")

    def _ask_name(self) -> None:
        self._asked.clear()
        with self._asked:
            field = ui.input("New name", value=self._name).classes("grow").props("dense")
            marked(field, "new-name")

            async def done() -> None:
                self._asked.clear()
                if self._rename is not None and field.value and field.value != self._name:
                    await self._rename(str(field.value))

            field.on("keydown.enter", done)
            marked(
                ui.button("Rename", on_click=done).props("no-caps dense").classes("px-2"), "rename"
            )
            ui.button("Keep", on_click=self._asked.clear).props("no-caps dense flat")

    def _ask_twice(self) -> None:
        self._asked.clear()

        async def done() -> None:
            self._asked.clear()
            if self._delete is not None:
                await self._delete()

        with self._asked:
            ui.label(f"Delete {self._name} for good?").classes("text-sm")
            delete = ui.button("Delete", on_click=done).props("no-caps dense color=red-8")
            marked(delete.classes("px-2"), "delete")
            ui.button("Keep", on_click=self._asked.clear).props("no-caps dense flat")
