"""Jobs of one's own: what the editor holds is kept under a name, and each can be managed."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

from nicegui import ui

from deltactl.web.manage import Manage
from deltactl.web.style import labelled
from deltactl.web.visit import Visit

LOOK_S = 3.0
NONE_YET = "None yet: give what the editor holds a name, and save it."


class OwnJobsList:
    """A field for the name, and a row for each job that is kept."""

    def __init__(
        self,
        visit: Visit,
        held: Callable[[], tuple[str, str]],
        opens: Callable[[str, str], Awaitable[None]],
    ):
        """held: name and text that the editor holds; opens: puts a job into it."""
        self._visit, self._held, self._opens = visit, held, opens
        self._shown: list[str] | None = None
        ui.separator()
        with ui.row().classes("w-full items-center gap-2 no-wrap"):
            ui.label("Your jobs").classes("font-bold whitespace-nowrap")
            if visit.operates:
                self._name = ui.input("Name").props("dense data-testid=job-name").classes("grow")
                save = ui.button("Save", icon="save", on_click=self.save)
                save.props("no-caps dense outline data-testid=save").classes("px-2")
        self._list = ui.column().classes("w-full gap-0").props("data-testid=own-jobs")
        self.look()
        ui.timer(LOOK_S, self.look)

    def look(self) -> None:
        """Follow what is kept, also by other pages."""
        names = list(self._visit.site.jobs.files())
        if names == self._shown:
            return
        self._shown = names
        self._list.clear()
        with self._list:
            if not names:
                ui.label(NONE_YET).classes("text-sm text-gray-600")
            for name in names:
                self._row(name)

    def _row(self, name: str) -> None:
        operates = self._visit.operates
        with ui.row().classes("w-full items-center gap-2 no-wrap"):
            opened = ui.button(name, icon="description", on_click=partial(self._open, name))
            opened.props("flat no-caps dense align=left").classes("grow ellipsis")
            labelled(opened, f"open {name}")
            manage = Manage(
                name,
                partial(self._rename, name) if operates else None,
                partial(self._delete, name) if operates else None,
                partial(self._download, name),
            )
        manage.below()

    async def save(self) -> None:
        """Keep what the editor holds, under the name in the field or that of the file."""
        name_now, text = self._held()
        name = str(self._name.value or name_now)
        kept = await self._visit.act("save the job", self._visit.site.jobs.save, name, text)
        if kept is not None:
            self.look()
            ui.notify(f"{kept} is kept", type="positive")
            await self._opens(str(kept), text)

    async def _open(self, name: str) -> None:
        path = self._visit.site.jobs.files().get(name)
        if path is not None:
            await self._opens(name, path.read_text(encoding="utf-8"))

    async def _rename(self, name: str, wanted: str) -> Any:
        await self._visit.act("rename", self._visit.site.jobs.rename, name, wanted)
        self.look()

    async def _delete(self, name: str) -> None:
        await self._visit.act("delete", self._visit.site.jobs.delete, name)
        self.look()

    def _download(self, name: str) -> None:
        path = self._visit.site.jobs.files().get(name)
        if path is not None:
            ui.download.content(path.read_bytes(), name)
