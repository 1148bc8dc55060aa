"""What the rows of a table say of time: how many, how far apart, and where some are missing."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from deltactl.recording.foreign.names import Guess, read_name, without_unit
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.units import IN_SI
from deltactl.recording.reading.columns import FloatArray
from deltactl.recording.tables.flat import GAP_PERIODS

Facts = list[tuple[str, str]]
NO_COLUMN = (
    "no column increases all the way: where rows are evenly spaced, say --set rate_hz=100 with the"
    " rows per second"
)


def row_number(guesses: Mapping[str, Guess], table: Mapping[str, FloatArray]) -> str | None:
    """The column that is taken for the time and only counts the rows; None where there is none."""
    time = _time_of(guesses)
    if time is None or (time.unit is not None and time.unit != "s") or time.why == "as you say":
        return None
    named = read_name(time.source).role == "t"
    return time.source if not named and bool((np.diff(table[time.source]) == 1.0).all()) else None


def rows_and_times(
    guesses: Mapping[str, Guess],
    table: Mapping[str, FloatArray],
    kind: str | None,
    rate_hz: float | None,
) -> tuple[Facts, list[str]]:
    """Facts about the rows, and what to look at; rate_hz: what somebody says in place of times."""
    rows = len(next(iter(table.values())))
    time = _time_of(guesses)
    if rate_hz is not None:
        return [("rows", f"{rows}, {rate_hz:g} a second, as you say")], []
    if time is None and kind == "range_sensor":
        return [("rows", f"{rows}, without times, which a ranging sensor does not need")], []
    if time is None:
        return [("rows", str(rows))], [NO_COLUMN]
    step_s = np.diff(table[time.source]) * IN_SI[time.unit or "s"]
    parts = next((table[one.source] for one in guesses.values() if one.role == "segment"), None)
    if parts is not None:  # times may start again with each
        step_s = step_s[(step_s > 0.0) | (np.diff(parts) == 0.0)]
    doubts = _doubts(time.source, step_s, row_number(guesses, table))
    if kind != "range_sensor" and time.unit == "s" and time.why != "as you say":
        doubts += _slow(time.source, step_s)
    return _facts(rows, step_s), doubts


def _time_of(guesses: Mapping[str, Guess]) -> Guess | None:
    return next((guess for guess in guesses.values() if guess.role == "t"), None)


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
            f"{name}: its steps are uneven, as where a computer stamps what arrives; if the file"
            " has the clock of the device that took the readings, say --set t=THAT_COLUMN; if they"
            f" were taken evenly, --set rate_hz={1 / mean:.4g} (their mean rate) in place of"
            " --set t=..."
        )
    return doubts
