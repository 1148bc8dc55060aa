"""The healing that the page has asked for: one at a time, for everybody who looks at the page.

The work is that of `deltactl heal`, in a process of its own, which asks the daemon as the command
does. It goes on when a browser is closed, and it ends with the page, as with a killed command.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from deltactl.firmware_py.controller.contract import Status
from deltactl.foundation.errors import DeltactlError, NotReady
from deltactl.foundation.plain_file import write_whole
from deltactl.web.behind.link import DaemonLink
from deltactl.web.behind.tasks import Tasks

ANSWER = "shown.json"


class Healings:
    """Begin, follow, and take back."""

    def __init__(self, link: DaemonLink, tasks: Tasks, work: Path):
        """work: a folder of the page's own."""
        self._link, self._tasks, self._work = link, tasks, work
        self._task: asyncio.Task[None] | None = None
        self._begun_s = 0.0
        self._says = ""
        self.problem = ""
        """Why the last one ended early; empty where it did not."""

    @property
    def progress(self) -> str:
        """What is being done; empty while nothing is healed."""
        if self._task is None or self._task.done():
            return ""
        minutes, seconds = divmod(round(time.monotonic() - self._begun_s), 60)
        return f"{minutes}:{seconds:02d} {self._says}"

    def answer(self, status: Status) -> dict[str, Any] | None:
        """What came of the last one of this robot: its `lines` and `outcome`."""
        with suppress(OSError, ValueError):
            found: dict[str, Any] = json.loads((self._folder(status) / ANSWER).read_text("utf-8"))
            return found
        return None

    def report(self, status: Status) -> Path:
        """Where the report of the last one is."""
        return self._folder(status) / "report.html"

    def begun(self, status: Status) -> bool:
        """Whether one of this robot was begun, which can go on."""
        return (self._folder(status) / "healing.json").is_file()

    def begin(self, status: Status) -> None:
        """Heal the robot that runs, or go on where the last one stopped. Raises NotReady."""
        if self.progress:
            raise NotReady("a healing is under way already")
        self.problem, self._says, self._begun_s = "", "beginning", time.monotonic()
        self._task = asyncio.create_task(self._carry_out(status))

    def undo(self, status: Status) -> bool:
        """Put the robot file back and home by it; False where it is there. Raises DeltactlError."""
        from deltactl.repair.healing_state import undo

        if self.progress:
            raise NotReady("cannot undo: a healing is under way")
        changed = undo(self._folder(status), Path(status.robot_path))
        with suppress(OSError):
            (self._folder(status) / ANSWER).unlink()
        with self._link.client() as client:
            client.home(robot=Path(status.robot_path))
        return changed

    async def _carry_out(self, status: Status) -> None:
        folder = self._folder(status)
        folder.mkdir(parents=True, exist_ok=True)
        goes_on = "go_on" if self.begun(status) else "begin"
        try:
            place = await asyncio.to_thread(self._link.place)
            words = (folder, status.robot_path, place, goes_on)
            answer = await self._tasks.run("heal", *words, progress=self._tell)
            write_whole(folder / ANSWER, json.dumps(answer))
        except DeltactlError as error:
            self.problem = str(error)

    def _tell(self, text: str) -> None:
        self._says = text

    def _folder(self, status: Status) -> Path:
        return healing_folder(self._work, status)


def healing_folder(work: Path, status: Status) -> Path:
    """Where the page keeps what it heals: a folder for each robot file."""
    key = hashlib.sha256(status.robot_path.encode("utf-8")).hexdigest()[:12]
    return work / "heal" / f"{Path(status.robot_path).stem}-{key}"
