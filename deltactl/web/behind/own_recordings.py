"""Recordings that somebody sends to the page: kept under names of ours, and not for ever."""

from __future__ import annotations

import asyncio
import os
import re
import secrets
import shutil
from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import yaml

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
        ending = next((known for known in ENDINGS if shown.lower().endswith(known)), None)
        if ending is None:
            raise RecordingError(
                f"{shown}: a recording to open here ends in .csv, .csv.gz or .mcap; for others:"
                " deltactl inspect FILE"
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
            self.remove(kept)
            raise
        finally:
            self._busy = False
        for old in list(self.newest_first())[MOST:]:
            self.remove(old)
        return kept

    def newest_first(self) -> Iterator[Path]:
        """What is kept."""
        found = [path for path in self._folder.glob("*") if path.name.endswith(ENDINGS)]
        yield from sorted(found, key=lambda path: path.stat().st_mtime_ns, reverse=True)

    def name_of(self, path: Path) -> str:
        """As it was called by whoever sent it; empty for what is none of these."""
        return name_beside(path) if path.parent == self._folder else ""

    def rename(self, path: Path, name: str) -> None:
        """Call one otherwise, which is shown and reaches no path. Raises RecordingError."""
        if not path.is_file() or path.parent != self._folder:
            raise RecordingError(f"{plain_name(name)}: that recording is gone; look again")
        write_whole(path.with_name(f"{path.name}.name"), plain_name(name))

    def remove(self, path: Path) -> None:
        """Forget one."""
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


def chosen_beside(path: Path) -> Path:
    """Where is written what was chosen of a table's columns."""
    return path.with_name(f"{path.name}{CHOSEN}")


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
    return "".join(letter for letter in last if letter.isprintable())[-LONGEST_NAME:] or otherwise


AS_IT_IS = "1"
"""The unit of what is in the contract's already, or is none."""


@dataclass(frozen=True, slots=True)
class Chosen:
    """A column of the table, what it is, and in which unit; no name: it is not used."""

    column: str
    name: str
    unit: str


def inspected(path: Path) -> dict[str, Any]:
    """How a table is read, guessed from its headings and values; plain types for the page.

    Raises RecordingError.
    """
    from deltactl.recording.foreign.inspection import inspect
    from deltactl.recording.foreign.notes import Hint
    from deltactl.recording.foreign.units import UNITS_OF
    from deltactl.recording.tables.flat import UNITS

    found = inspect(path)
    mapped = {source.from_: name for name, source in found.mapping.columns.items()}
    columns = []
    for column, values in found.table.items():
        name = mapped.get(column, column if column in UNITS else "")
        unit = found.mapping.columns[name].unit if column in mapped else AS_IT_IS
        first = ", ".join(f"{value:.6g}" for value in values[:3])
        columns.append({"column": column, "name": name, "unit": unit, "first": first})
    units = {name: UNITS_OF.get(re.sub(r"_[123xyz]$", "", name), ()) for name in UNITS}
    return {
        "columns": columns,
        "units_of": {name: [AS_IT_IS, *known] for name, known in units.items()},
        "mapping": found.mapping_text(),
        "warnings": [
            warning.chosen if isinstance(warning, Hint) else warning for warning in found.warnings
        ],
    }


def mapping_text(guessed: str, chosen: Iterable[Chosen]) -> str:
    """The mapping file of a choice. guessed: the one of the inspection, which knows factors too."""
    mapping = yaml.safe_load(guessed)
    before, mapping["columns"] = mapping.get("columns") or {}, {}
    for choice in chosen:
        if choice.name:
            same = before.get(choice.name, {})
            kept = same.get("from") == choice.column and same.get("unit", AS_IT_IS) == choice.unit
            mapping["columns"][choice.name] = (
                same if kept else {"from": choice.column, "unit": choice.unit}
            )
    return str(yaml.safe_dump(mapping, sort_keys=False, allow_unicode=True))


def reader() -> Callable[[Path], Any]:
    """What reads recordings: tables by the columns that were chosen, or else found in them."""
    from deltactl.recording.foreign.inspection import inspect
    from deltactl.recording.foreign.mapping import load_mapping
    from deltactl.recording.foreign.reading import read_mapped
    from deltactl.recording.tables.flat_files import is_own_run, read_flat

    def read(path: Path) -> Any:
        chosen = chosen_beside(path)
        if chosen.is_file():
            return read_mapped(path, load_mapping(chosen))
        if is_own_run(path):
            return read_flat(path)
        found = inspect(path).mapping
        foreign = any(its.from_ != name or its.unit != "1" for name, its in found.columns.items())
        return read_mapped(path, found) if foreign else read_flat(path)

    return read
