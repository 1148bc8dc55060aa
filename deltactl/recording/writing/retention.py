"""Old recordings make room for new ones."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import stat
import time
from dataclasses import dataclass
from pathlib import Path

from deltactl.foundation.plain_file import write_whole


@dataclass(frozen=True, slots=True)
class _Old:
    path: Path
    size: int
    modified_s: float


def prune(
    folder: Path,
    max_bytes: int | None = None,
    max_age_s: float | None = None,
    keep_free_bytes: int = 0,
    now_s: float | None = None,
) -> list[Path]:
    """Delete the oldest `.mcap` files of a folder until every limit given is kept.

    Only plain files directly in `folder`; never one that is being written (it is locked), and
    never the newest. Which is older goes by the order in which they were first seen here, not by
    a clock that may have been set back. Returns what was deleted, oldest first; what cannot be
    deleted is left.
    """
    now_s = time.time() if now_s is None else now_s
    found = in_sequence(folder, _recordings(folder))
    total = sum(old.size for old in found)
    deleted: list[Path] = []
    for old in found[:-1]:
        too_old = max_age_s is not None and now_s - old.modified_s > max_age_s
        too_many = max_bytes is not None and total > max_bytes
        too_full = shutil.disk_usage(folder).free < keep_free_bytes
        if (too_old or too_many or too_full) and _delete(old.path):
            deleted.append(old.path)
            total -= old.size
    return deleted


SEQUENCE = ".sequence"
"""Names of the recordings of a folder in the order in which they came, one a line."""
MOST_BYTES = 16 * 2**20


def in_sequence(folder: Path, found: list[_Old]) -> list[_Old]:
    """Recordings in the order in which they came; new ones, by their times, are put at the end."""
    known = _known(folder)
    place = {name: number for number, name in enumerate(known)}
    ordered = sorted(found, key=lambda old: (place.get(old.path.name, len(place)), old.modified_s))
    names = [old.path.name for old in ordered]
    if names != known:
        _remember(folder, names)
    return ordered


def _known(folder: Path) -> list[str]:
    try:
        descriptor = os.open(folder / SEQUENCE, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW)
    except OSError:
        return []
    with os.fdopen(descriptor, "rb") as file:
        return file.read(MOST_BYTES).decode("utf-8", "surrogateescape").split("\n")[:-1]


def _remember(folder: Path, names: list[str]) -> None:
    """A folder that may not be written is looked through all the same."""
    text = "".join(f"{name}\n" for name in names if "\n" not in name)
    with contextlib.suppress(OSError):
        data = text.encode("utf-8", "surrogateescape")
        write_whole(folder / SEQUENCE, data, follow=False, mode=0o640)


def _recordings(folder: Path) -> list[_Old]:
    if not folder.is_dir():
        return []
    found = []
    for path in folder.glob("*.mcap"):
        with contextlib.suppress(FileNotFoundError):  # somebody else deleted it meanwhile
            state = path.lstat()
            if stat.S_ISREG(state.st_mode):
                found.append(_Old(path, state.st_size, state.st_mtime))
    return found


def _delete(path: Path) -> bool:
    """Delete unless a recorder holds it."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        path.unlink()
    except OSError:
        return False
    finally:
        os.close(descriptor)
    return True
