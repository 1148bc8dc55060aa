"""What the rows of a table say of time: how many, how far apart, where some are missing, and which
do not increase.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from deltactl.recording.foreign.guess import CALIBRATES
from deltactl.recording.foreign.names import ALONE, Guess, Taken, of_role, read_name, without_unit
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import Table, counts, is_whole, rising
from deltactl.recording.foreign.units import IN_SI
from deltactl.recording.reading.run import FloatArray
from deltactl.recording.tables.cells import (
    advice,
    mean_rate_hz,
    not_increasing,
    seldom_back,
    those_rows,
)
from deltactl.recording.tables.flat import GAP_PERIODS

Facts = list[tuple[str, str]]
NO_TIMES_OF_POSES = "without times, which poses at rest do not need"
NO_TIMES = (
    "no column increases all the way, so that none is the time; where the rows are evenly spaced,"
    " say how many come a second: --set rate_hz=RATE"
)
"""The same of a table that no command is printed for."""
NO_COLUMN = (
    f"no column increases all the way: the printed command takes {GUESSES.rate_hz:g} rows a second;"
    " put the right number in place of it in --set rate_hz"
)


def row_number(guesses: Taken, table: Table) -> str | None:
    """The column that is taken for the time and only counts the rows; None where there is none."""
    time = _time_of(guesses)
    if time is None or time.why != ALONE or time.unit not in (None, "s"):
        return None
    return time.source if counts(table[time.source]) else None


def rows_and_times(
    guesses: Taken,
    table: Table,
    kind: str | None,
    rate_hz: float | None,
    noted: tuple[float, str] | None = None,
) -> tuple[Facts, list[str]]:
    """Facts about the rows, and what to look at; rate_hz: what somebody says in place of times;
    noted: what a line above the table says of them, and that line.
    """
    rows = len(next(iter(table.values())))
    time, poses = _time_of(guesses), any(one.why.endswith(CALIBRATES) for one in guesses.values())
    if time is None or rate_hz is not None:
        said = (rate_hz, "as you say") if rate_hz is not None else None
        said = said or (noted and (noted[0], f"as '{noted[1]}' says"))
        return _without_a_clock(rows, kind, said, poses)
    step_s = np.diff(table[time.source]) * IN_SI[time.unit or "s"]
    parts = next((table[name] for name in of_role(guesses, "segment")), None)
    if parts is not None:  # times may start again with each
        step_s = step_s[(step_s > 0.0) | (np.diff(parts) == 0.0)]
    counter = row_number(guesses, table)
    if counter and poses:
        return [("rows", f"{rows}, {NO_TIMES_OF_POSES}")], []
    doubts = _doubts(time.source, step_s, counter)
    if kind != "range_sensor" and time.unit == "s" and time.why != "as you say":
        doubts += _slow(time.source, step_s)
    return _facts(rows, step_s), doubts


def _without_a_clock(
    rows: int, kind: str | None, said: tuple[float, str] | None, poses: bool
) -> tuple[Facts, list[str]]:
    """The same of a table whose times are not read; said: how many rows come a second, and who
    says so. poses: they were measured at rest.
    """
    if said is not None:
        return [("rows", f"{rows}, {said[0]:g} a second, {said[1]}")], []
    if kind == "range_sensor":
        return [("rows", f"{rows}, without times, which a distance sensor does not need")], []
    if poses:
        return [("rows", f"{rows}, {NO_TIMES_OF_POSES}")], []
    return [("rows", str(rows))], [NO_TIMES if kind is None else NO_COLUMN]


def _time_of(guesses: Taken) -> Guess | None:
    return next((guesses[name] for name in of_role(guesses, "t")), None)


def _facts(rows: int, step_s: FloatArray) -> Facts:
    usual = float(np.median(step_s))
    words = f"{rows} in {float(step_s.sum()):.4g} s, one every {usual:.4g} s ({1 / usual:.4g} Hz)"
    facts = [("rows", words)]
    long = step_s > GAP_PERIODS * usual
    missing = (step_s > GUESSES.row_missing * usual) & ~long
    if missing.any() and not uneven(step_s):
        longest = float(step_s[missing].max())
        are = "step is" if missing.sum() == 1 else "steps are"
        facts.append(
            (
                "missing",
                f"{int(missing.sum())} {are} longer than usual, up to {longest:.3g} s: rows are"
                " missing there",
            )
        )
    if long.any():
        gaps = f"{int(long.sum())} longer than {GAP_PERIODS * usual:.3g} s; each starts a stretch"
        facts.append(("gaps", gaps))
    return facts


def uneven(step_s: FloatArray) -> bool:
    """Whether steps of time (n,) differ, but for a few."""
    apart = np.abs(step_s / float(np.median(step_s)) - 1.0)
    return bool(np.mean(apart > GUESSES.large_jitter) > GUESSES.most_uneven)


def _slow(name: str, step_s: FloatArray) -> list[str]:
    """A word of a heading that says seconds where the rows of a machine would be far apart."""
    usual = float(np.median(step_s))
    plain = without_unit(name)
    if usual < GUESSES.longest_step_s or read_name(name).unit != "s":
        return []
    return [
        f"{name}: is said to be s, and one row comes every {usual:.4g} s; ms? Then say"
        f' --set "t={plain}[ms]*1" in place of --set t=...'
    ]


def _doubts(name: str, step_s: FloatArray, counter: str | None) -> list[str]:
    usual = float(np.median(step_s))
    doubts = []
    if counter is not None:
        doubts.append(
            f"{name}: it counts the rows and is taken for seconds; where more rows than one come in"
            " a second, say how many: --set rate_hz=100 in place of --set t=..."
        )
    if uneven(step_s):
        mean = float(step_s[step_s <= GAP_PERIODS * usual].mean())
        doubts.append(
            f"{name}: its steps are uneven, as where a computer stamps what arrives; where a column"
            " has the clock of the device itself, say --set t=COLUMN; where readings were taken"
            f" evenly, --set rate_hz={1 / mean:.4g} (their mean rate) in place of --set t=..."
        )
    return doubts


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

    def instead_of(self, late: Sequence[str]) -> list[str]:
        """What is to be looked at of the times, this in place of that there are none."""
        return [self.says, *(one for one in late if one not in (NO_COLUMN, NO_TIMES))]


def stumbling(
    guesses: Taken, table: Table, lines: Sequence[int], kind: str | None
) -> Stumbling | None:
    """What is to be said of the times, None where they increase all the way or are not needed.

    lines: of the rows in the file; empty where it has none. kind: of the machine.
    """
    time = _time_of(guesses)
    two = _in_two_columns(table)
    if two is not None and kind != "range_sensor" and (time is None or time.source in two.says):
        return two
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
            time.source, None, f"{says}; delete {those} before you type the printed command"
        )
    return Stumbling(
        time.source,
        float(f"{rate_hz:.4g}"),
        f"{says}; the printed command takes the rows as evenly spaced, {rate_hz:.4g} a second"
        f" (their mean rate); where they are not, delete {those} and inspect the file again",
    )


PARTS = (1e9, 1e6, 1e3)
"""How many parts a second has in the column beside whole seconds."""


def _in_two_columns(table: Table) -> Stumbling | None:
    """A clock whose whole seconds and whose parts of a second are two columns."""
    for name, whole in table.items():
        if read_name(name).role != "t" or not is_whole(whole) or rising(whole):
            continue
        for other, part in table.items():
            most = next((ticks for ticks in PARTS if 0.1 * ticks < np.nanmax(part) < ticks), None)
            if other == name or most is None or not rising(t_s := whole + part / most):
                continue
            rate_hz = mean_rate_hz(t_s) or 1.0 / float(np.mean(np.diff(t_s)))
            return Stumbling(
                name,
                float(f"{rate_hz:.4g}"),
                f"{name}, {other}: one clock in two columns; the printed command takes the rows as"
                f" evenly spaced, {rate_hz:.4g} a second (their mean rate); where they are not, put"
                " both into one column and inspect the file again",
            )
    return None


def _named_only(table: Table, lines: Sequence[int]) -> Stumbling | None:
    """A column that is called a time and cannot be one as it is."""
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
