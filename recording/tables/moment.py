"""Times of day and dates in the cells of tables, as loggers and spreadsheets write them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np

from recording.reading.columns import FloatArray

_CLOCK = r"\d\d:\d\d(:\d\d([.,]\d+)?)?"
_ISO = re.compile(rf"\d{{4}}-\d\d-\d\d[T ]{_CLOCK}(Z|[-+]\d\d:?\d\d)?")
_GERMAN = re.compile(rf"(\d\d?)\.(\d\d?)\.(\d{{4}}),? ({_CLOCK})")
_OF_DAY = re.compile(r"\d\d:\d\d:\d\d([.,]\d+)?")
_DAY_S = 86400.0


def is_moment(cell: str) -> bool:
    """Whether a cell holds a time: 2024-05-01 12:00:00.5, 1.5.2024 12:00:00,5 or 12:00:00.5."""
    return any(form.fullmatch(cell) for form in (_ISO, _GERMAN, _OF_DAY))


def seconds(cells: Sequence[str]) -> FloatArray:
    """Times in cells as seconds since the first, shape (n,); NaN where a cell holds none.

    A time of day that falls by half a day and more is on the next day.
    """
    first = _moment(cells[0])
    since = np.array(
        [(_moment(cell) - first).total_seconds() if is_moment(cell) else np.nan for cell in cells]
    )
    if _OF_DAY.fullmatch(cells[0]):
        midnights = np.nan_to_num(np.diff(since, prepend=0.0)) < -0.5 * _DAY_S
        since = since + _DAY_S * np.cumsum(midnights)
    return since


def _moment(cell: str) -> datetime:
    if german := _GERMAN.fullmatch(cell):
        day, month, year, clock = german[1], german[2], german[3], german[4]
        cell = f"{year}-{int(month):02d}-{int(day):02d} {clock}"
    elif _OF_DAY.fullmatch(cell):
        cell = f"2000-01-01 {cell}"
    moment = datetime.fromisoformat(cell.replace(",", "."))
    return moment if moment.tzinfo else moment.replace(tzinfo=UTC)
