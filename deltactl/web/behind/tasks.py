"""Starts workers, one diagnosis at a time, and hands on what they say."""

from __future__ import annotations

import asyncio
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import ServiceError

Progress = Callable[[str], None]
LONGEST_LINE = 8 * 2**20
AT_ONCE = {"diagnose": 1}
OTHERS_AT_ONCE = 2


class Tasks:
    """Runs `deltactl.web.behind.worker` processes; what is too much waits its turn."""

    def __init__(self) -> None:
        self._places: dict[str, asyncio.Semaphore] = {}

    async def run(
        self, kind: str, *files: Path, progress: Progress = lambda _: None
    ) -> dict[str, Any]:
        """Do one piece of work. Raises ServiceError with the worker's one line."""
        places = self._places.setdefault(kind, asyncio.Semaphore(AT_ONCE.get(kind, OTHERS_AT_ONCE)))
        if places.locked():
            progress("waiting for its turn")
        async with places:
            return await self._run(kind, files, progress)

    async def _run(self, kind: str, files: tuple[Path, ...], progress: Progress) -> dict[str, Any]:
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-P", "-m", "deltactl.web.behind.worker", kind, *map(str, files),
            stdout=asyncio.subprocess.PIPE, stdin=asyncio.subprocess.DEVNULL,
            limit=LONGEST_LINE,
        )  # fmt: skip
        assert process.stdout is not None
        try:
            async for line in process.stdout:
                message = json.loads(line)
                if "progress" in message:
                    progress(str(message["progress"]))
                elif "error" in message:
                    raise ServiceError(str(message["error"]))
                elif "result" in message:
                    return dict(message["result"])
            raise ServiceError(f"the {kind.replace('_', ' ')} ended without an answer")
        finally:
            if process.returncode is None:
                process.kill()
            await process.wait()
