"""Messages on a missing column: what could replace it, and what was meant by it."""

from __future__ import annotations

import difflib
import itertools
from collections.abc import Collection
from pathlib import Path

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.names import of_contract, read_name, without_unit
from deltactl.recording.foreign.units import A_FACTOR, IN_SI
from deltactl.recording.tables.table_format import IN_OPTIONS, SEPARATORS, guess_marks

STANDS_IN = {
    "command": "effort, with `inertia` in the robot file",
    "effort": "command",
    "position": "theta_1",
    "theta_1": "position",
    "steps_1": "command_1 (rad at the arm)",
    "command_1": "steps_1, with `drive` in the robot file",
    "distance": "a constant (`distance=0.2`), if the target stood still",
}
NO_TIME = (
    'no column with times is named; name it with its unit, as --set "t=COLUMN[ms]"; or, where the'
    " rows are evenly spaced, add --set rate_hz=50 with the rows per second"
)
MOST_MEANT = 2
"""Columns that are proposed in place of one that is not there."""
MOST_LISTED = 200
"""Letters of names."""
FEW_LETTERS = 3
"""Shorter words occur in many names."""


def no_column(path: Path, name: str, wanted: str, there: list[str]) -> RecordingError:
    """What is said where the table has no column `wanted`, which is to be read as `name`."""
    plain = without_unit(wanted)
    if plain != wanted and plain in there:
        unit = wanted[len(plain) :].strip().strip("[]()")
        return RecordingError(
            f"{path}: --set {name}={wanted}: the unit '{unit}' is not known; it must be one of"
            f" {', '.join(IN_SI)}, {A_FACTOR}"
        )
    of = f" (for {name})" if wanted != name else ""
    return RecordingError(
        f"{path}: column '{wanted}'{of} is missing{_way(name, wanted, there)}; the table has"
        f" {listed(there)}"
    )


def no_time(path: Path, there: list[str]) -> RecordingError:
    """What is said where nobody says which column holds the times."""
    times = [one for one in there if _may_be("t", one)]
    meant = f"'{without_unit(times[0])}' looks like one: " if times else ""
    return RecordingError(f"{path}: {meant}{NO_TIME}; the table has {listed(there)}")


def other_separator(path: Path, said: str | None) -> str:
    """What to type where the columns are not separated as `said`; empty where they are."""
    if said is None:
        return ""
    try:
        found, _ = guess_marks(path)
    except RecordingError:
        return ""
    if found == said:
        return ""
    right, wrong = (IN_OPTIONS.get(mark, mark) for mark in (found, said))
    return (
        f"the table is separated by {SEPARATORS[found]}: type --set separator={right} in place of"
        f" separator={wrong}, or leave it out"
    )


def _way(name: str, wanted: str, there: list[str]) -> str:
    """Columns that could be meant by a name, or replace it."""
    near = [one for one in there if len(wanted) >= FEW_LETTERS and wanted.lower() in one.lower()]
    near += difflib.get_close_matches(wanted, [without_unit(one) for one in there], n=1, cutoff=0.6)
    if near:
        return f"; did you mean '{near[0]}'?"
    alike = [one for one in there if one != wanted and _may_be(name, one)]
    if alike and wanted != name:
        return f"; did you mean {' or '.join(map(repr, alike[:MOST_MEANT]))}?"
    return _instead(name, there)


def _instead(name: str, there: list[str]) -> str:
    """What the columns that are there hold in place of one that is missing."""
    other = STANDS_IN.get(name)
    if name == "theta_1" and any(map(_of_further_motor, there)):
        other = None  # a single position says nothing of three arms
    if other is None:
        return ""
    column = other.split()[0].rstrip(",")
    if name != "distance" and not any(_may_be(column, one) for one in there):
        return ""
    return f"; {other} could replace it"


def _may_be(name: str, column: str) -> bool:
    """Whether a column is called as what the contract calls `name`."""
    if column == name:
        return True
    role, index = of_contract(name)
    named = read_name(column)
    role = "position" if role in ("theta", "pos") else role
    return named.role == role and (index is None or named.index in (None, index))


def _of_further_motor(column: str) -> bool:
    """Whether a column is called as that of a second or third motor, as q2."""
    named = read_name(column)
    return named.index in ("2", "3") and named.role in ("command", "position", "steps")


def listed(names: Collection[str]) -> str:
    """As many names as a message has room for, and how many more there are."""
    long = itertools.accumulate(len(name) + 2 for name in names)
    shown = list(names)[: max(sum(end <= MOST_LISTED for end in long), 1)]
    more = len(names) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")
