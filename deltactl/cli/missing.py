"""Recordings that are not there, with the nearest name beside them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path

from deltactl.foundation.errors import RecordingError


def refuse_missing(recordings: Iterable[Path]) -> None:
    """Raise RecordingError for the first file or folder that is not there."""
    for path in recordings:
        if path.exists():
            continue
        folder = path.parent
        there = [one.name for one in folder.iterdir()] if folder.is_dir() else []
        close = difflib.get_close_matches(path.name, there, n=1, cutoff=0.75)
        hint = f"; did you mean '{folder / close[0]}'?" if close else ""
        raise RecordingError(f"{path}: no such file{hint}")
