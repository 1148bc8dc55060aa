"""Which column is what, from names where there are any and from numbers where there are none."""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from deltactl.recording.foreign.axis_columns import Columns, scored
from deltactl.recording.foreign.by_values import by_values, partners
from deltactl.recording.foreign.names import (
    ALONE,
    BY_NAME,
    Guess,
    Named,
    of_contract,
    of_role,
    read_name,
)
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.owners_factors import (
    named_by_pulses,
    named_in_inches,
    steps_commanded,
)
from deltactl.recording.foreign.shapes import (
    Table,
    copies_of_others,
    correlation,
    counts,
    difference,
    is_count,
    of_one_motion,
    repeats,
    rising,
    same_range,
    starts_again,
    unevenness,
)
from deltactl.recording.foreign.units import TIMES
from deltactl.recording.format.messages import MOTORS
from deltactl.recording.tables.cells import seldom_back
from deltactl.recording.tables.flat import BESIDE, UNITS

MOTIONS = frozenset({"position", "command", "steps", "range", "distance"})
LETTERED = frozenset({"position", "command", "steps"})
"""What motors a, b and c have; letters after a current may as well be its phases."""
OF_A_MOTOR = (*LETTERED, "effort", "velocity")
"""What a motor has one of."""
MOTOR_NUMBERS, AXES = tuple("123"), tuple("xyz")
OURS = frozenset(name for name in UNITS if name.rpartition("_")[0] in ("status", "disturbance")) | {
    "t_pwm"
}
"""Columns of the contract with words in their names that mean something else elsewhere."""
CURRENTS = frozenset(f"current_{motor}" for motor in range(1, MOTORS + 1))
"""The same where all are there; one alone is the effort of an axis."""
_LETTER = re.compile(r"(.+[_ .-])([a-cA-C])")
_AXIS = re.compile(r"((?:.*[^A-Za-z])?)([xyzXYZ])((?:_[a-z]+)?(?:\s*[\[(]\w+[\])])?)")
"""A name that ends as an axis and perhaps a unit: x_mm, Tracker X [mm]."""


def guess_columns(table: Table, units: Mapping[str, str], named: bool) -> dict[str, Guess]:
    """A guess for each column that one could be made for, by its name in the file."""
    spelled = _letters(list(table))
    thin = {name: values[: GUESSES.guessed_rows] for name, values in table.items()}
    said = {name: read_name(spelled[name], units.get(name, "")) for name in table}
    said |= named_by_pulses(thin, said)
    said |= named_in_inches(thin, said)
    ours = _ours(table, said) if named else {}
    said |= ours if named else {name: Named(None, one.unit, None) for name, one in said.items()}
    first = Columns(thin, said, _by_name(said))
    for correct in BY_NAME_THEN:
        correct(first)
    again = _once_more(first)
    first = first.less(again)
    copies = copies_of_others(thin, first.found) | again
    usable = {n: values for n, values in thin.items() if said[n].used and n not in copies}
    by_numbers = partners if named and first.of(*MOTIONS) else by_values
    further = by_numbers(replace(first, table=usable))
    found = _numbered(first.found | {guess.source: guess for guess in further})
    for name in ours.keys() & found.keys():
        found[name] = replace(found[name], index=ours[name].index)
    found = _calibration(found)
    return _unique(scored(Columns(usable | {n: thin[n] for n in found}, said, found)))


def _by_name(said: Mapping[str, Named]) -> dict[str, Guess]:
    """What names alone say; an effort that was measured comes before one that was asked for."""
    ordered = sorted(said.items(), key=lambda one: one[1].role == "effort" and one[1].asked)
    return {
        name: Guess(name, what.role, what.index, what.unit, BY_NAME)
        for name, what in ordered
        if what.role is not None
    }


def _ours(table: Collection[str], said: Mapping[str, Named]) -> dict[str, Named]:
    """What columns are that an exported run has: whatever their names say elsewhere."""
    ours: dict[str, Named] = {}
    known = OURS | CURRENTS if set(table) >= CURRENTS else OURS
    for name in table:
        if name in known:
            role, index = of_contract(name)
            ours[name] = replace(said[name], role=role, index=index)
        elif name in BESIDE and "t" in table:
            ours[name] = Named(None, None, None, used=False)
    return ours


def _letters(names: list[str]) -> dict[str, str]:
    """How each name is read: soll_A, soll_B and soll_C are three motors, and no amperes; x, y and z
    are a place.
    """
    axes = {name: _AXIS.fullmatch(name) for name in names}
    around = [(axis[1], axis[3]) for axis in axes.values() if axis]
    places = {
        name: f"pos_{axis[2].lower()}{axis[3]}"
        for name, axis in axes.items()
        if axis
        and around.count((axis[1], axis[3])) == 3
        and read_name(f"{axis[1]}x{axis[3]}").role == "position"
    }
    ends = {name: _LETTER.fullmatch(name) for name in names}
    stems = [end[1] for end in ends.values() if end]
    return {
        name: f"{end[1]}{'abc'.index(end[2].lower()) + 1}"
        if end and stems.count(end[1]) == MOTORS and read_name(f"{end[1]}1").role in LETTERED
        else name
        for name, end in ends.items()
    } | places


def _once_more(columns: Columns) -> set[str]:
    """Columns that hold the motion of another one in another unit, where a third moves alike: the
    motor's steps beside its command and a scale that reads the axis. Of two, the counts.
    """
    table = columns.table
    motions = [n for n in (*columns.of(*MOTIONS), *columns.free()) if columns.said[n].used]
    again = set[str]()
    for one, other in itertools.combinations(dict.fromkeys(motions), 2):
        motors = {columns.said[name].index for name in (one, other)} - {None}
        if {one, other} & again or not columns.found.keys() & {one, other} or len(motors) > 1:
            continue
        if _repeats(table, one, other) and _third(table, one, other, motions):
            again.add(one if is_count(table[one]) and not is_count(table[other]) else other)
    return again


def _repeats(table: Table, one: str, other: str) -> bool:
    """Whether two columns that differ are one motion in two units; in a few rows first."""
    few = slice(None, None, max(len(table[one]) // GUESSES.compared_first, 1))
    return all(
        repeats(table[one][rows], table[other][rows])
        and not np.array_equal(table[one][rows], table[other][rows], equal_nan=True)
        for rows in (few, slice(None))
    )


def _third(table: Table, one: str, other: str, motions: Collection[str]) -> bool:
    """Whether a column moves as two others do and holds something else."""
    return any(
        correlation(table[name], table[one]) >= GUESSES.alike
        and of_one_motion(table[name], table[one])
        and not any(repeats(table[name], table[n]) for n in (one, other))
        for name in motions
        if name not in (one, other)
    )


def _counts_between(columns: Columns) -> None:
    """Counts by which a command and a reading lie apart are no steps: droop pulses."""
    movers = columns.of(*LETTERED)
    if len(movers) > GUESSES.few_columns:
        return
    error = difference(columns.table, movers)
    if error is not None and columns.role(error) == "steps":
        del columns.found[error]


def _twins(columns: Columns) -> None:
    """Counts named as a command's but for the stem are what came of it: cmd_counts, pos_counts."""
    table, asked = columns.table, columns.of("command")
    for name in columns.of("steps"):
        stem, _, end = name.rpartition("_")
        if read_name(stem).role != "position":
            continue
        for twin in asked:
            if twin.rpartition("_")[2] == end and same_range(table[name], table[twin]):
                why = f"named and ranging as {twin}"
                columns.found[name] = replace(columns.found[name], role="position", why=why)


def _steps_commanded(columns: Columns) -> None:
    """Commands called steps are steps where what came of them has a unit."""
    columns.found.update(steps_commanded(columns.found, columns.said, columns.table))


def _measured_distance(columns: Columns) -> None:
    """What was measured beside a true distance, and followed no command, is a range."""
    seen, far, found = columns.of("position"), columns.of("distance"), columns.found
    if columns.of("command", "steps", "range") or not far or len(seen) != 1:
        return
    if correlation(columns.table[seen[0]], columns.table[far[0]]) < GUESSES.alike:
        return
    why = "by its name, beside a true distance"
    found[seen[0]] = replace(found[seen[0]], role="range", why=why)


def _distance_of_an_axis(columns: Columns) -> None:
    """The only distance, or count, beside a command that it goes with is what an axis answered,
    where nothing else goes with the command.
    """
    found, table = columns.found, columns.table
    asked = [name for name, guess in found.items() if guess.name == "command"]
    seen = [n for n, guess in found.items() if guess.name in ("distance", "range", "steps")]
    if len(asked) != 1 or len(seen) != 1 or columns.of("position"):
        return
    if any(correlation(table[asked[0]], table[n]) >= GUESSES.alike for n in columns.free()):
        return
    if correlation(table[asked[0]], table[seen[0]]) >= GUESSES.alike:
        why = f"by its name, and it follows {asked[0]}"
        found[seen[0]] = replace(found[seen[0]], role="position", why=why)


def _ranges_that_follow(columns: Columns) -> None:
    """A distance that is negative, or has no range that goes with it where other columns move, is
    no true one.
    """
    far, table = columns.of("distance"), columns.table
    near = [name for name in table if name not in far and np.nanstd(table[name]) > 0.0]
    for name in far:
        goes = any(abs(correlation(table[name], table[n])) >= GUESSES.alike for n in near)
        if not goes or np.nanmin(table[name]) < 0.0:
            del columns.found[name]


def _time(columns: Columns) -> None:
    """The one time column: named so, or the evenest of those that only increase.

    One that is named so may fail to increase in a few rows, which are mistakes.
    """
    named = sorted(columns.of("t"), key=lambda name: "log_time" in name)  # the sender's says more
    tests = (rising, starts_again, seldom_back) if columns.of("segment") else (rising, seldom_back)
    good = (name for test in tests for name in named if test(columns.table[name]))
    time = next(good, None)
    time = _evenest(columns) if time is None else time
    for name in named:
        del columns.found[name]
    if time is not None:
        unit = columns.said[time].unit
        why = BY_NAME if time in named else ", in ".join(filter(None, [ALONE, unit]))
        columns.found[time] = columns.taken(time, "t", None, why)


def _evenest(columns: Columns) -> str | None:
    """The evenest of the columns that only increase and are nothing else; else the first column
    where it is as even as a clock.
    """
    table = columns.table
    even = {name: unevenness(one) for name, one in table.items() if rising(one)}
    times = {None, *TIMES}
    free = [n for n in even if n not in columns.found and columns.said[n].unit in times]
    if free:
        return min(free, key=lambda name: (counts(table[name]), even[name]))
    first = next(iter(table), "")
    is_clock = even.get(first, 1.0) < GUESSES.clockwork and len(table) > len(even) + 1
    return first if is_clock else None


BY_NAME_THEN = (
    _counts_between,
    _twins,
    _steps_commanded,
    _ranges_that_follow,
    _measured_distance,
    _distance_of_an_axis,
    _time,
)
"""What puts the guesses by name right, one after the other."""


def _numbered(found: dict[str, Guess]) -> dict[str, Guess]:
    """Numbers 0 to 2 become 1 to 3; single axes lose theirs; three arms are measured as theta."""
    if any(guess.index == "0" for guess in found.values()):
        from_one = {"0": "1", "1": "2", "2": "3"}
        found = {
            name: replace(one, index=from_one.get(one.index or "", one.index))
            for name, one in found.items()
        }
    single = len({one.index for one in found.values()} & {*MOTOR_NUMBERS}) < 2
    places = {found[name].index for name in of_role(found, "position")} >= {*AXES}
    found = {name: _as_numbered(one, single, places) for name, one in found.items()}
    if of_role(found, "steps"):
        for name, one in found.items():
            if one.name == "position":
                found[name] = replace(one, role="theta", index="1")
    return found


def _as_numbered(one: Guess, single: bool, places: bool) -> Guess:
    """A column by its number; single: no second motor is there; places: x, y and z are."""
    if one.role == "position" and one.index in AXES and (places or not single):
        return replace(one, role="pos")
    if one.role in OF_A_MOTOR and single:
        return replace(one, index="1" if one.role == "steps" else None)
    if one.role == "position" and one.index in MOTOR_NUMBERS:
        return replace(one, role="theta")
    return one


CALIBRATES = "no command is there, and it says where the platform was to be"


def _calibration(found: dict[str, Guess]) -> dict[str, Guess]:
    """Angles of three arms beside places of the platform, without commands, take their part."""
    there = {guess.name for guess in found.values()}
    arms, places = {f"theta_{n}" for n in (1, 2, 3)}, {f"pos_{axis}" for axis in "xyz"}
    if not there >= arms | places or {"command_1", "steps_1"} & there:
        return found
    return found | {
        name: replace(found[name], role="command", why=f"{found[name].why}; {CALIBRATES}")
        for name in of_role(found, "theta")
    }


def _unique(found: dict[str, Guess]) -> dict[str, Guess]:
    """The first of columns that would be the same."""
    first: dict[str, Guess] = {}
    for guess in found.values():
        if guess.name not in {kept.name for kept in first.values()}:
            first[guess.source] = guess
    return first
