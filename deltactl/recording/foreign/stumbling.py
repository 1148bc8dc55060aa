"""Times of a table that increase but for a few rows: which those are, and what stands for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from deltactl.recording.foreign.names import Guess, read_name
from deltactl.recording.foreign.timing import uneven
from deltactl.recording.foreign.units import IN_SI
from deltactl.recording.reading.columns import FloatArray
from deltactl.recording.tables.moment import (
    advice,
    mean_rate_hz,
    not_increasing,
    seldom_back,
    those_rows,
)

SHOWN = 3
"""So many of the rows are named; the others are counted."""
FEWEST = 3
"""Rows that a column of times has."""


class Stumbling(NamedTuple):
    """A column of times that does not increase in a few rows."""

    name: str
    rate_hz: float | None
    """By which the rows are read in place of it; None where they are not evenly apart."""
    says: str


def stumbling(
    guesses: Mapping[str, Guess],
    table: Mapping[str, FloatArray],
    lines: Sequence[int],
    kind: str | None,
) -> Stumbling | None:
    """What is to be said of the times, None where they increase all the way or are not needed.

    lines: of the rows in the file; empty where it has none. kind: of the machine.
    """
    time = next((guess for guess in guesses.values() if guess.role == "t"), None)
    if time is None:
        return None if kind == "range_sensor" else _named_only(table, lines)
    values = table[time.source]
    if not seldom_back(values) or not len(not_increasing(values)):
        return None
    says, those = _says(time.source, values, lines), those_rows(values)
    t_s = values * IN_SI[time.unit or "s"]
    rate_hz = mean_rate_hz(t_s)
    if time.why == "as you say" or rate_hz is None:
        return Stumbling(time.source, None, f"{says}; {advice(t_s)}")
    if uneven(np.diff(values)):
        return Stumbling(
            time.source, None, f"{says}; delete {those} before you type the command below"
        )
    return Stumbling(
        time.source, float(f"{rate_hz:.4g}"),
        f"{says}; the command below takes the rows as evenly spaced, {rate_hz:.4g} a second (their"
        f" mean rate); where they are not, delete {those} and inspect the file again",
    )  # fmt: skip


def _named_only(table: Mapping[str, FloatArray], lines: Sequence[int]) -> Stumbling | None:
    """A column that is called a time and cannot be one as it stands."""
    for name, values in table.items():
        named = read_name(name)
        if named.role != "t" or not np.isfinite(values).all() or len(values) < FEWEST:
            continue
        t_s = values * IN_SI[named.unit or "s"]
        return Stumbling(name, None, f"{_says(name, values, lines)}; {advice(t_s)}")
    return None


def _says(name: str, values: FloatArray, lines: Sequence[int]) -> str:
    rows = not_increasing(values).tolist()
    return f"{name}: does not increase {_where(values, rows, lines)}"


def _where(values: FloatArray, rows: Sequence[int], lines: Sequence[int]) -> str:
    """The rows, by their lines, with the times of the first."""
    first = f"{values[rows[0]]:.10g} after {values[rows[0] - 1]:.10g}"
    shown = [str(lines[row] if len(lines) else row + 1) for row in rows[:SHOWN]]
    what = "line" if len(lines) else "row"
    more = len(rows) - len(shown)
    if len(rows) == 1:
        return f"at {what} {shown[0]} ({first})"
    listed = ", ".join(shown) + (f" and {more} more" if more else "")
    return f"at {what}s {listed} (the first: {first})"
