"""Starts workers, one diagnosis at a time, and hands on what they say.

A worker is a module that takes a kind of work and words, and prints one JSON object a line, as
`deltactl.web.behind.worker` does.
"""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import ServiceError

Progress = Callable[[str], None]
LONGEST_LINE = 8 * 2**20
WORKER = "deltactl.web.behind.worker"
AT_ONCE = {"diagnose": 1, "heal": 1}
OTHERS_AT_ONCE = 2
LIMITS_S = {
    "check_job": 120.0,
    "check_robot": 60.0,
    "inspect": 60.0,
    "compare": 300.0,
    "errors": 300.0,
    "playback": 300.0,
    "run_report": 600.0,
    "diagnose": 1800.0,
    "heal": 3600.0,
}
"""From its start, not counting its turn: some ten times what the largest took that is let in."""
INSTEAD = {
    "check_job": "deltactl check FILE",
    "check_robot": "deltactl check FILE",
    "inspect": "deltactl inspect FILE",
    "run_report": "deltactl report FILE",
    "diagnose": "deltactl diagnose FILE",
    "heal": "deltactl heal FILE",
}
"""What takes as long as it takes."""
OTHERS_WAITING = 20
"""So many of a kind may wait for their turn."""


class Tasks:
    """Runs processes of a worker; what is too much waits its turn."""

    def __init__(self, limits_s: Mapping[str, float] = LIMITS_S, worker: str = WORKER) -> None:
        """limits_s: how long each kind may take [s]; then it is ended, with all it has started.

        worker: the module that does the work.
        """
        self._limits_s, self._worker = limits_s, worker
        self._places: dict[str, asyncio.Semaphore] = {}
        self._waiting: dict[str, int] = {}

    async def run(
        self, kind: str, *words: str | Path, progress: Progress = lambda _: None
    ) -> dict[str, Any]:
        """Do one piece of work. Raises ServiceError with the worker's one line, or at its limit."""
        async with self._turn(kind, progress):
            limit_s = self._limits_s[kind]
            try:
                async with asyncio.timeout(limit_s):
                    return await _run(self._worker, kind, words, progress)
            except TimeoutError:
                raise ServiceError(_given_up(kind, limit_s)) from None

    @asynccontextmanager
    async def _turn(self, kind: str, progress: Progress) -> AsyncIterator[None]:
        """Wait for a place. Raises ServiceError where too many wait already."""
        places = self._places.setdefault(kind, asyncio.Semaphore(AT_ONCE.get(kind, OTHERS_AT_ONCE)))
        if places.locked():
            if self._waiting.get(kind, 0) >= OTHERS_WAITING:
                raise ServiceError(f"{OTHERS_WAITING} wait for the same already; try again later")
            progress("waiting for its turn")
        self._waiting[kind] = self._waiting.get(kind, 0) + 1
        try:
            await places.acquire()
        finally:
            self._waiting[kind] -= 1
        try:
            yield
        finally:
            places.release()


async def _run(
    worker: str, kind: str, words: tuple[str | Path, ...], progress: Progress
) -> dict[str, Any]:
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-P",
        "-m",
        worker,
        kind,
        *map(str, words),
        stdout=asyncio.subprocess.PIPE,
        stdin=asyncio.subprocess.DEVNULL,
        limit=LONGEST_LINE,
        start_new_session=True,
    )
    assert process.stdout is not None
    try:
        async for line in process.stdout:
            message = json.loads(line)
            if "progress" in message:
                progress(str(message["progress"]))
            elif "error" in message:
                error = ServiceError(str(message["error"]))
                error.typed = str(message.get("typed", ""))
                raise error
            elif "result" in message:
                return dict(message["result"])
        raise ServiceError(f"the {_work(kind)} ended without an answer")
    finally:
        # Also what the worker has forked, which holds the processor and may outlive it.
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()


def _given_up(kind: str, limit_s: float) -> str:
    long = f"{limit_s / 60:g} min" if limit_s >= 60 else f"{limit_s:g} s"
    instead = f"; without a limit: {INSTEAD[kind]}" if kind in INSTEAD else ""
    return f"the {_work(kind)} was given up after {long}{instead}"


_NOUNS = {"diagnose": "diagnosis", "compare": "comparison", "heal": "healing"}


def _work(kind: str) -> str:
    return _NOUNS.get(kind, kind.replace("_", " "))
