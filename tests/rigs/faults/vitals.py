"""What a process costs just now, as Linux counts it."""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass
from pathlib import Path

PAGE_KB = os.sysconf("SC_PAGE_SIZE") // 1024


@dataclass(frozen=True, slots=True)
class Vitals:
    """Resident memory, open files and threads of a process and its children."""

    rss_kb: int
    files: int
    threads: int


def vitals(pid: int | None = None) -> Vitals:
    """Of a process (this one, if none is given) and the children it has now."""
    root = os.getpid() if pid is None else pid
    found = [_of(one) for one in (root, *_children(root))]
    return Vitals(
        sum(one.rss_kb for one in found),
        sum(one.files for one in found),
        sum(one.threads for one in found),
    )


def _of(pid: int) -> Vitals:
    home = Path(f"/proc/{pid}")
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        pages = int((home / "statm").read_text().split()[1])
        files = len(os.listdir(home / "fd"))
        return Vitals(pages * PAGE_KB, files, len(os.listdir(home / "task")))
    return Vitals(0, 0, 0)


def _children(pid: int) -> list[int]:
    found = []
    for home in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            parent = (home / "stat").read_text().rpartition(")")[2].split()[1]
            if int(parent) == pid:
                found.append(int(home.name))
    return found
