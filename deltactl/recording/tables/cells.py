"""What the cells of a table hold: numbers, and times of day and dates as loggers and spreadsheets
write them; and what is said of a cell that holds none.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.printable import count
from deltactl.recording.reading.run import FloatArray

_MOST_SHOWN = 40
MOSTLY = 0.5
"""Share of numbers from which on a column is one of numbers, and its text a mistake."""
MISSING = frozenset({"nan", "na", "n/a", "null", "none", "nil", "inf", "+inf", "-inf", "-", "--"})
"""What logs write where there is no reading."""


def number(cell: str, decimal: str = ".") -> float | None:
    """The number in a cell; None where it holds none, an empty one included.

    Python's own float() also takes 1_0 for ten, and digits of any script: neither is a number
    here, nor to the programs that write tables.
    """
    plain = cell if decimal == "." else cell.replace(decimal, ".")
    if "_" in plain or not plain.isascii():
        return None
    try:
        return float(plain)
    except ValueError:
        return None


def is_number(cell: str, decimal: str) -> bool:
    """Whether a cell holds a number that is not infinite (or nothing) with this decimal mark."""
    if decimal == "," and "." in cell:
        return False
    value = number(cell, decimal)
    return not cell if value is None else not math.isinf(value)


def not_a_number(path: Path, line: int, name: str, cell: str) -> RecordingError:
    """What is said of a cell that should hold a number; `line` counts from 1."""
    return RecordingError(f"{path}:{line}: {name} must be a number (got {cell[:_MOST_SHOWN]!r})")


def wrong_count(path: Path, line: int, found: int, wanted: int) -> RecordingError:
    """What is said of a row that has more or fewer cells than the heading."""
    cells = {0: "is empty", 1: "has one cell"}.get(found, f"has {found} cells")
    return RecordingError(
        f"{path}:{line}: this row {cells}, the heading has {wanted}; complete or delete the row, or"
        " separate it as the others are"
    )


def text_among_numbers(
    heading: Sequence[str], rows: Sequence[tuple[int, str, Sequence[str]]], decimal: str
) -> Iterator[str]:
    """A sentence for each column (of a heading) in which a few cells are neither number nor empty.

    rows: line in the file from 1, its text, its cells.
    """
    for place, name in enumerate(heading):
        found = [
            (line, cells[place].strip())
            for line, _, cells in rows
            if not is_number(cells[place].strip(), decimal)
        ]
        wrong = [(line, cell) for line, cell in found if cell.lower() not in MISSING]
        if not wrong or len(found) > (1.0 - MOSTLY) * len(rows):
            continue
        line, cell = wrong[0]
        more = f" ({count(len(wrong) - 1, 'more cell')} of it likewise)" if len(wrong) > 1 else ""
        yield (
            f"line {line}: {cell[:_MOST_SHOWN]!r} in column '{name}' is no number and is read as no"
            f" reading{more}"
        )


IntArray = np.ndarray[Any, np.dtype[np.intp]]
FAR_BACK = 20.0
"""Usual steps of time beyond which one is a gap, and one backwards the beginning of another run."""
SELDOM = 0.02
"""Share of the rows up to which times that do not increase are mistakes, not the clock's steps."""
_CLOCK = r"\d\d?:\d\d(?::\d\d(?:[.,]\d+)?)?"
_ISO = re.compile(rf"\d{{4}}-\d\d-\d\d(?:[T ]{_CLOCK}(?:Z|[-+]\d\d:?\d\d)?)?")
_GERMAN = re.compile(rf"(\d\d?)\.(\d\d?)\.(\d{{4}})(?:,? ({_CLOCK}))?")
_SLASHED = re.compile(
    rf"(\d\d?|\d{{4}})/(\d\d?)/(\d\d?|\d{{4}})(?:,? ({_CLOCK})(?: ?([AaPp])[Mm])?)?"
)
_OF_DAY = re.compile(r"(\d\d?:\d\d:\d\d(?:[.,]\d+)?)(?: ?([AaPp])[Mm])?")
_MOMENT = re.compile("|".join(form.pattern for form in (_ISO, _GERMAN, _SLASHED, _OF_DAY)))
_DAY_S = 86400.0
_MONTHS = 12
_MIDNIGHT = "00:00:00"

NEAR_USUAL = 0.5
"""Part of the usual time step by which a step may differ and be one between two rows."""


def is_moment(cell: str) -> bool:
    """Whether a cell holds a time: 2024-05-01 12:00:00.5, 1.5.2024 12:00:00,5, 5/1/2024 1:02 PM,
    a date alone, or 12:00:00.5.
    """
    begins = cell[:1].isdecimal()  # as all four do: most cells that are asked about are words
    return begins and _MOMENT.fullmatch(cell) is not None


def is_date(cell: str) -> bool:
    """Whether a cell holds a day and no time of it."""
    forms = (_ISO, _GERMAN, _SLASHED)
    return ":" not in cell and any(form.fullmatch(cell) for form in forms)


def is_time_of_day(cell: str) -> bool:
    """Whether a cell holds a time, and no day."""
    return _OF_DAY.fullmatch(cell) is not None


def seconds(cells: Sequence[str]) -> FloatArray:
    """Times in cells as seconds since the first, shape (n,); NaN where a cell holds none.

    A time of day that falls by half a day and more is on the next day. Dates with slashes have the
    month first where their clock has AM and PM, or where no month could be second.
    """
    month_first = _month_first(cells)
    moments = [_moment(cell, month_first) if is_moment(cell) else None for cell in cells]
    first = moments[0]
    since = np.array(
        [
            np.nan if moment is None or first is None else (moment - first).total_seconds()
            for moment in moments
        ]
    )
    if is_time_of_day(cells[0]):
        midnights = np.nan_to_num(np.diff(since, prepend=0.0)) < -0.5 * _DAY_S
        since = since + _DAY_S * np.cumsum(midnights)
    return since


def _month_first(cells: Sequence[str]) -> bool:
    """Which order dates with slashes are in. Within one day either gives the same seconds."""
    found = [one for cell in cells if (one := _SLASHED.fullmatch(cell))]
    if any(int(one[1]) > _MONTHS for one in found):
        return False
    return any(int(one[2]) > _MONTHS or one[5] for one in found) or _few_days(found)


def _few_days(found: Sequence[re.Match[str]]) -> bool:
    """Whether the second number is what changes: that of days does so first."""
    return len({one[2] for one in found}) > len({one[1] for one in found})


def _moment(cell: str, month_first: bool) -> datetime | None:
    """The moment of a cell that looks like one; None where the calendar has no such day."""
    if german := _GERMAN.fullmatch(cell):
        day, month, year = german[1], german[2], german[3]
        cell = f"{year}-{int(month):02d}-{int(day):02d} {german[4] or _MIDNIGHT}"
    elif slashed := _SLASHED.fullmatch(cell):
        cell = f"{_slashed_date(slashed, month_first)} {_clock(slashed[4], slashed[5])}"
    elif of_day := _OF_DAY.fullmatch(cell):
        cell = f"2000-01-01 {_clock(of_day[1], of_day[2])}"
    try:
        moment = datetime.fromisoformat(_two_digits(cell).replace(",", "."))
    except ValueError:
        return None
    return moment if moment.tzinfo else moment.replace(tzinfo=UTC)


def _slashed_date(slashed: re.Match[str], month_first: bool) -> str:
    one, two, three = slashed[1], slashed[2], slashed[3]
    if len(one) > 2:
        year, month, day = one, two, three
    else:
        year = three if len(three) > 2 else f"20{int(three):02d}"
        month, day = (one, two) if month_first else (two, one)
    return f"{year}-{int(month):02d}-{int(day):02d}"


def _clock(clock: str | None, half: str | None) -> str:
    """A time of day over 24 hours; half: the a or p of AM and PM."""
    clock = clock or _MIDNIGHT
    if half is None:
        return clock
    hour, rest = clock.split(":", 1)
    return f"{int(hour) % 12 + (12 if half in 'Pp' else 0):02d}:{rest}"


def _two_digits(cell: str) -> str:
    """9:05 as 09:05, which ISO wants."""
    return re.sub(r"(?<=[ T])(?=\d:)", "0", cell)


def not_increasing(t_s: FloatArray) -> IntArray:
    """The rows whose time is not after that of the row before."""
    return np.flatnonzero(np.diff(t_s) <= 0.0) + 1


def seldom_back(t_s: FloatArray) -> bool:
    """Whether times (n,) increase but for a few mistakes, and never begin again."""
    step = np.diff(t_s)
    if len(step) < 2 or not np.isfinite(step).all() or not np.median(step) > 0.0:
        return False
    back = int(np.count_nonzero(step <= 0.0))
    few = back <= max(1.0, SELDOM * len(t_s))
    return few and float(step.min()) > -FAR_BACK * float(np.median(step))


def mean_rate_hz(t_s: FloatArray) -> float | None:
    """Rows per second without pauses and steps back; None where no time goes on.

    A few steps back, and what makes up for them, are left out; where many steps are 0 the clock is
    too coarse, and they count.
    """
    step = np.diff(t_s)
    if not (step > 0.0).any():
        return None
    usual = float(np.median(step[step > 0.0]))
    kept = step[(step >= 0.0) & (step <= FAR_BACK * usual)]
    near = step[np.abs(step - usual) < NEAR_USUAL * usual]
    if seldom_back(t_s) and len(near) > len(step) / 2:
        kept = near
    return 1.0 / float(np.mean(kept))


def advice(t_s: FloatArray) -> str:
    """What to do about times (n,) that do not increase all the way."""
    step, rate_hz = np.diff(t_s), mean_rate_hz(t_s)
    if rate_hz is None:
        return "it is no column of times"
    evenly = (
        f"if the rows were taken evenly, say so with --set rate_hz={rate_hz:.4g} (their mean rate)"
        " in place of their times"
    )
    if float(step.min()) < -FAR_BACK * float(np.median(step[step > 0.0])):
        return (
            "where another run begins, give each run a file of its own, or number the runs in a"
            f" column that is called segment; {evenly}"
        )
    if not seldom_back(t_s):
        return f"its steps are too coarse, or it is no column of times; {evenly}"
    return f"delete {those_rows(t_s)}, or, {evenly}"


def those_rows(t_s: FloatArray) -> str:
    """What the rows are called whose time does not increase."""
    return "that row" if len(not_increasing(t_s)) == 1 else "those rows"
