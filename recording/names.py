"""Names for new recordings."""

from __future__ import annotations

import datetime
import itertools
import re
from pathlib import Path

_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9._-]+")


def fresh_path(folder: Path, job_name: str, start: datetime.datetime | None = None) -> Path:
    """`folder/<job>-<date>T<time>.mcap`, with a number behind when that is taken."""
    start = start or datetime.datetime.now()
    plain = _NOT_IN_NAMES.sub("-", job_name).strip("-.") or "run"
    stem = f"{plain}-{start:%Y-%m-%dT%H-%M-%S}"
    for number in itertools.count(1):
        path = folder / (f"{stem}.mcap" if number == 1 else f"{stem}-{number}.mcap")
        if not path.exists():
            return path
    raise AssertionError("numbers do not end")
