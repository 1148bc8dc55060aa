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
    never the newest. Returns what was deleted, oldest first; what cannot be deleted is left.
    """
    now_s = time.time() if now_s is None else now_s
    found = sorted(_recordings(folder), key=lambda old: old.modified_s)
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
