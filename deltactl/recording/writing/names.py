"""Names for new recordings."""

from __future__ import annotations

import datetime
import itertools
import re
from collections.abc import Container
from pathlib import Path

from deltactl.foundation.errors import RecordingError

ENDING = ".mcap"
LONGEST = 200
"""Characters; file systems take 255 bytes."""
_PLAIN = re.compile(r"[^\x00-\x1f\x7f/\\]+")
_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9._-]+")


def confined(folder: Path, wanted: str) -> Path:
    """Path of a recording that somebody asked for: directly in the folder, whatever they wrote.

    `wanted` is a name, or a whole path that lies there. Creating it afterwards must not follow
    links (AppendFile does not). Raises RecordingError.
    """
    given = Path(wanted)
    home = folder.absolute()
    if given.is_absolute() and given.parent in (home, home.resolve()):
        given = Path(given.name)
    name = given.name if given.suffix == ENDING else f"{given.name}{ENDING}"
    if given.name != str(given) or not _PLAIN.fullmatch(name) or name.startswith("."):
        raise RecordingError(
            f"{wanted[:LONGEST]!r}: recordings lie directly in {home}; give a plain name"
        )
    if len(name) > LONGEST:
        raise RecordingError(f"the name of a recording may have {LONGEST} characters; shorten it")
    return home / name


def fresh_path(
    folder: Path,
    job_name: str,
    start: datetime.datetime | None = None,
    taken: Container[Path] = (),
) -> Path:
    """`folder/<job>-<date>T<time>.mcap`, with a number behind when that is there or taken."""
    start = start or datetime.datetime.now()
    plain = _NOT_IN_NAMES.sub("-", job_name).strip("-.") or "run"
    stem = f"{plain}-{start:%Y-%m-%dT%H-%M-%S}"
    for number in itertools.count(1):
        path = folder / (f"{stem}.mcap" if number == 1 else f"{stem}-{number}.mcap")
        if path not in taken and not path.exists():
            return path
    raise AssertionError("numbers do not end")
