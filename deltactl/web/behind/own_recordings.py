"""Recordings that somebody sends to the page: kept under names of ours, and not for ever."""

from __future__ import annotations

import asyncio
import os
import secrets
import shutil
from collections.abc import AsyncIterable, AsyncIterator, Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import whole_file, write_whole

ENDINGS = (".csv.gz", ".csv", ".mcap")
MAX_BYTES = 64 * 2**20
MOST = 10
"""So many are kept; the oldest goes first."""
LEAST_FREE_BYTES = 2**30
"""On the disk, which the robot's own recordings need."""
LONGEST_NAME = 60
LONGEST_PAUSE_S = 20.0
"""Without a byte for so long a recording on its way is given up: it keeps others waiting."""
CHOSEN = ".columns.yaml"
"""Behind a table's name: what was chosen of its columns."""


class OwnRecordings:
    """A folder of recordings that no robot here has made."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._busy = False

    async def take(self, name: str, body: AsyncIterable[bytes]) -> Path:
        """Keep what a browser sends; its name is only shown. Raises RecordingError."""
        shown = plain_name(name)
        ending = next((one for one in ENDINGS if shown.lower().endswith(one)), None)
        if ending is None:
            raise RecordingError(
                f"{shown}: a recording to open here ends in .csv, .csv.gz or .mcap; for others:"
                " deltactl diagnose FILE --inspect"
            )
        if self._busy:
            raise RecordingError(f"{shown}: another recording is on its way; wait for it")
        self._folder.mkdir(parents=True, exist_ok=True)
        if shutil.disk_usage(self._folder).free < LEAST_FREE_BYTES + MAX_BYTES:
            raise RecordingError(f"{shown}: the disk is nearly full; free 1 GB for the robot's own")
        kept = self._folder / f"{secrets.token_hex(8)}{ending}"
        self._busy = True
        try:
            with whole_file(kept) as out:
                await _write(out, shown, body)
                write_whole(kept.with_name(f"{kept.name}.name"), shown)
        except BaseException:
            self._remove(kept)
            raise
        finally:
            self._busy = False
        for old in list(self.newest_first())[MOST:]:
            self._remove(old)
        return kept

    def newest_first(self) -> Iterator[Path]:
        """What is kept."""
        found = [one for one in self._folder.glob("*") if one.name.endswith(ENDINGS)]
        yield from sorted(found, key=lambda one: one.stat().st_mtime_ns, reverse=True)

    def name_of(self, path: Path) -> str:
        """As it was called by whoever sent it; empty for what is none of these."""
        return name_beside(path) if path.parent == self._folder else ""

    def _remove(self, path: Path) -> None:
        for ending in ("", ".name", CHOSEN):
            path.with_name(f"{path.name}{ending}").unlink(missing_ok=True)


async def _next(pieces: AsyncIterator[bytes], shown: str) -> bytes | None:
    """None at the end. Raises RecordingError where nothing comes."""
    try:
        async with asyncio.timeout(LONGEST_PAUSE_S):
            return await anext(pieces, None)
    except TimeoutError:
        raise RecordingError(
            f"{shown}: nothing came of it for {LONGEST_PAUSE_S:g} s; send it again"
        ) from None


def name_beside(path: Path) -> str:
    """What a recording was called by whoever sent it; of a robot's own run the file's name."""
    with suppress(OSError):
        return path.with_name(f"{path.name}.name").read_text(encoding="utf-8")
    return path.name


async def _write(out: BinaryIO, shown: str, body: AsyncIterable[bytes]) -> None:
    size, pieces = 0, aiter(body)
    while (piece := await _next(pieces, shown)) is not None:
        size += len(piece)
        if size > MAX_BYTES:
            raise RecordingError(f"{shown}: more than {MAX_BYTES // 2**20} MB are not taken")
        out.write(piece)
    if size == 0:
        raise RecordingError(f"{shown}: is empty")
    out.flush()
    await asyncio.to_thread(os.fsync, out.fileno())  # a slow disk does not hold up the page


def plain_name(name: str, otherwise: str = "unnamed") -> str:
    """A file's name as a browser tells it, without folders and without what is not printed."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    return "".join(one for one in last if one.isprintable())[-LONGEST_NAME:] or otherwise
