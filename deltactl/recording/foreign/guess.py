"""Which column is what, from names where there are any and from numbers where there are none; which
kind of machine the table is then of, and whether what is taken for an effort is one.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from deltactl.recording.foreign.by_values import COMMANDED, Columns, by_values, partners, scored
from deltactl.recording.foreign.mapping import as_option
from deltactl.recording.foreign.names import (
    ALONE,
    BY_NAME,
    Guess,
    Hint,
    Named,
    Taken,
    by_name,
    may_be_outside,
    of_contract,
    of_role,
    pulls,
    read_name,
    without_unit,
)
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import (
    Table,
    copies_of_others,
    correlation,
    counts,
    difference,
    rising,
    same_range,
    starts_again,
    unevenness,
)
from deltactl.recording.foreign.units import LINEAR, ROTARY
from deltactl.recording.format.messages import MOTORS
from deltactl.recording.reading.run import FloatArray
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
    said = {name: read_name(spelled[name], units.get(name, "")) for name in table}
    ours = _ours(table, said) if named else {}
    said |= ours if named else {name: Named(None, one.unit, None) for name, one in said.items()}
    thin = {name: values[: GUESSES.guessed_rows] for name, values in table.items()}
    first = Columns(thin, said, _by_name(said))
    for correct in BY_NAME_THEN:
        correct(first)
    copies = copies_of_others(thin, first.found)
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


def _measured_distance(columns: Columns) -> None:
    """What was measured beside a true distance, and followed no command, is a range."""
    seen, found = columns.of("position"), columns.found
    if columns.of("command", "steps", "range") or not columns.of("distance") or len(seen) != 1:
        return
    why = "by its name, beside a true distance"
    found[seen[0]] = replace(found[seen[0]], role="range", why=why)


def _distance_of_an_axis(columns: Columns) -> None:
    """The only distance beside a command that it goes with is what an axis answered."""
    found, table = columns.found, columns.table
    asked = [name for name, guess in found.items() if guess.name == "command"]
    seen = [name for name, guess in found.items() if guess.name in ("distance", "range")]
    if len(asked) != 1 or len(seen) != 1 or columns.of("position"):
        return
    if correlation(table[asked[0]], table[seen[0]]) >= GUESSES.alike:
        why = f"by its name, and it follows {asked[0]}"
        found[seen[0]] = replace(found[seen[0]], role="position", why=why)


def _ranges_that_follow(columns: Columns) -> None:
    """A distance without a range that goes with it, where other columns move, is no true one."""
    far, table = columns.of("distance"), columns.table
    near = [name for name in table if name not in far and np.nanstd(table[name]) > 0.0]
    for name in far:
        if not any(abs(correlation(table[name], table[n])) >= GUESSES.alike for n in near):
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
    free = [name for name in even if name not in columns.found]
    if free:
        return min(free, key=lambda name: (counts(table[name]), even[name]))
    first = next(iter(table), "")
    is_clock = even.get(first, 1.0) < GUESSES.clockwork and len(table) > len(even) + 1
    return first if is_clock else None


BY_NAME_THEN = (
    _counts_between,
    _twins,
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


class _Kind(NamedTuple):
    """A kind of machine, by the columns of its recordings."""

    name: str
    needs: tuple[str, ...]
    """At least one column of each of these, names with spaces between."""
    why: str
    without: str = ""

    def fits(self, there: set[str]) -> bool:
        """Whether the columns that are there are those of such a machine."""
        lacks = any(there.isdisjoint(either.split()) for either in self.needs)
        return not lacks and there.isdisjoint(self.without.split())


PLACE, DRIVEN = "position theta_1", "command effort"
KINDS = (
    _Kind("delta", ("steps_2", "steps_3"), "commands of three motors"),
    _Kind("delta", ("command_2", "command_3"), "commands of three motors"),
    _Kind("stepper_axis", ("steps_1", PLACE), "a count of steps, and the angle that came of it"),
    _Kind("range_sensor", ("range", "distance"), "distances, true and reported", DRIVEN),
    _Kind("servo_axis", (PLACE, DRIVEN), "{} in, position out"),
)
"""The first that fits counts."""


def kind_of(
    guesses: Taken, left: Sequence[str], constant: Iterable[str] = ()
) -> tuple[str | None, str | None, str]:
    """Kind of machine, linear or rotary, and why.

    left: columns that nothing is known of. constant: what has one value in all rows.
    """
    there = {guess.name for guess in guesses.values()} | {*constant}
    units = {guesses[name].unit for name in of_role(guesses, "command", "position", "theta")}
    motion = "rotary" if units & set(ROTARY) else "linear" if units & set(LINEAR) else None
    if any(one.why.endswith(CALIBRATES) for one in guesses.values()):
        return "delta", None, "angles of three arms, and where the platform was: a calibration"
    kind = next((one for one in KINDS if one.fits(there)), None)
    if kind is None:
        return None, motion, f"not enough is known: {_lacking(guesses, left)}"
    moves = motion if kind.name == "servo_axis" else None
    asked = " and ".join(sorted(there & {*DRIVEN.split()}))
    return kind.name, moves, kind.why.format(asked)


HERE = "inspect it with"


def _lacking(guesses: Taken, left: Sequence[str]) -> str:
    """What is needed besides, and how it is said; `left`: columns that nothing is known of."""
    named = by_name(guesses)
    if {"pos_x", "pos_y", "pos_z"} <= named.keys():
        return (
            "places of a platform were found, and no angles or steps of its three motors beside"
            f" them; name their columns: {HERE} --set command_1=COLUMN, or steps_1, to 3"
        )
    if "position" in named:
        return _lacking_beside(named["position"].source, left)
    if "range" in named:
        return (
            "the true distance was not found; name its column, or, where it is one for all rows,"
            f" say how large it is, in m: {HERE} --set distance=METRES"
        )
    likely = next((one for one in left if read_name(one).used and not pulls(one)), None)
    name = without_unit(likely or "COLUMN")
    asked, read = (shlex.join(["--set", f"{role}={name}"]) for role in ("position", "range"))
    return (
        f"a position or a reading was not found; name its column: {HERE} {asked}; of a distance"
        f" sensor, with {read} --set distance=COLUMN (or the true distance in m)"
    )


def _lacking_beside(position: str, left: Sequence[str]) -> str:
    """What is needed beside a position: a command or an effort."""
    twin = next((one for one in left if read_name(one).unit in (*LINEAR, *ROTARY)), None)
    if twin is not None:
        names = [without_unit(one) for one in (position, twin)]
        asked, read = (f"{role}={one}" for role, one in zip(COMMANDED, names, strict=True))
        return (
            f"{' and '.join(names)} both look like positions; say which was commanded and which was"
            f" read: {HERE} {shlex.join(['--set', asked, '--set', read])}"
        )
    likely = next((one for one in left if pulls(one)), left[0] if left else "COLUMN")
    name = without_unit(likely)
    example = shlex.join(["--set", f"effort={name}"])
    counts = (
        "" if pulls(likely) else f"; or, if it counts steps, --set {shlex.quote(f'steps_1={name}')}"
    )
    return f"a command or an effort was not found; name its column: {HERE} {example}{counts}"


def zero_of(guesses: Taken, table: Table) -> str | None:
    """Whether command and reading of an axis share their zero."""
    named = by_name(guesses)
    for asked, seen in (("command", "position"), ("command_1", "theta_1")):
        if asked not in named or seen not in named:
            continue
        one, other = named[asked], named[seen]
        if one.unit != other.unit:
            return None
        values = table[one.source]
        apart = abs(float(np.nanmedian(table[other.source] - values)))
        width = float(np.nanmax(values) - np.nanmin(values))
        return "arbitrary" if apart > GUESSES.zeros_apart * width else "absolute"
    return None


OF_THE_DRIVE = (
    "taken for what the drive itself gives; if it pulls at the axis from outside (a weight, a"
    " spring)"
)
OF_A_LOAD = (
    "taken for what pulls at the axis from outside (a weight, a spring), as it is 0 while the"
    " axis moves fastest; if the drive itself gives it"
)
ASKED = frozenset({"command", "command_1", "steps_1"})
MAY_BE_ASKED = (
    "{}: taken for an effort by its name; it goes where {} goes, over as much, and may be its"
    " command: then read it so with --set {}"
)


def may_be_asked(guesses: Taken, table: Table) -> list[str]:
    """A word of an effort that looks like the command of a position without one.

    u is what a controller gives, in the books the effort and in many a log what was asked for.
    """
    named = by_name(guesses)
    effort, seen = named.get("effort"), named.get("position") or named.get("theta_1")
    if effort is None or seen is None or effort.why != BY_NAME or ASKED & named.keys():
        return []
    if effort.unit not in (None, *ROTARY, *LINEAR):  # a heading in N m says what it is
        return []
    u, y = table[effort.source], table[seen.source]
    wide = float(np.nanmax(u) - np.nanmin(u)), float(np.nanmax(y) - np.nanmin(y))
    if correlation(u, y) < GUESSES.asked_alike or max(wide) > GUESSES.asked_as_far * min(wide):
        return []
    unit = effort.unit or seen.unit or "1"
    read = as_option("command", without_unit(effort.source), unit, None, 0.0)
    return [MAY_BE_ASKED.format(effort.source, seen.source, shlex.quote(read))]


def from_outside(guesses: Taken, table: Table) -> tuple[dict[str, Guess], list[str]]:
    """Guesses in which a torque that no drive gives is a load, and a word of what it was taken for.

    guesses: by column. table: columns, name -> (n,).
    """
    named = by_name(guesses)
    effort, seen = named.get("effort"), named.get("position")
    if effort is None or seen is None or "command" not in named or "load" in named:
        return dict(guesses), []
    if effort.why == "as you say" or not may_be_outside(effort.source):
        return dict(guesses), []
    if not _nothing_in_motion(table[effort.source], table[seen.source]):
        instead = "put load in place of effort in the printed command"
        return dict(guesses), [Hint(OF_THE_DRIVE, "name", effort.source, "load", instead)]
    load = replace(effort, role="load", why="it is 0 while the axis moves fastest")
    instead = "put effort in place of load in the printed command"
    hint = Hint(OF_A_LOAD, "name", effort.source, "effort", instead)
    return {**guesses, effort.source: load}, [hint]


def _nothing_in_motion(torque: FloatArray, place: FloatArray) -> bool:
    """Whether a torque (n,) is there at rest, and not where a drive would need it.

    A drive that moves an axis has friction and inertia to overcome.
    """
    speed = np.nan_to_num(np.abs(np.gradient(place)))
    most, top = float(np.nanmax(np.abs(torque))), float(np.quantile(speed, 0.99))
    fast = speed > GUESSES.fast_of_top * top
    nothing = np.nan_to_num(np.abs(torque)) <= GUESSES.no_torque * most
    enough = np.count_nonzero(fast) >= GUESSES.fewest_in_common
    return bool(enough and nothing[fast].all() and np.mean(~nothing) > GUESSES.pulled_at)
