"""Which column is what, from names where there are any and from numbers where there are none; which
kind of machine the table is then of, and whether what is taken for an effort is one.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from deltactl.recording.foreign.by_values import by_values, partners, scored
from deltactl.recording.foreign.mapping import as_option
from deltactl.recording.foreign.names import (
    ALONE,
    BY_NAME,
    Guess,
    Hint,
    Named,
    may_be_outside,
    of_contract,
    pulls,
    read_name,
    without_unit,
)
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import (
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
OURS = frozenset(name for name in UNITS if name.rpartition("_")[0] in ("status", "disturbance")) | {
    "t_pwm"
}
"""Columns of the contract with words in their names that mean something else elsewhere."""
CURRENTS = frozenset(f"current_{motor}" for motor in range(1, MOTORS + 1))
"""The same where all are there; one alone is the effort of an axis."""
_LETTER = re.compile(r"(.+[_ .-])([a-cA-C])")
_AXIS = re.compile(r"((?:.*[^A-Za-z])?)([xyzXYZ])((?:_[a-z]+)?(?:\s*[\[(]\w+[\])])?)")
"""A name that ends as an axis and perhaps a unit: x_mm, Tracker X [mm]."""


def guess_columns(
    table: Mapping[str, FloatArray], units: Mapping[str, str], named: bool
) -> dict[str, Guess]:
    """A guess for each column that one could be made for, by its name in the file."""
    spelled = _letters(list(table))
    said = {name: read_name(spelled[name], units.get(name, "")) for name in table}
    ours = _ours(table, said) if named else {}
    said |= ours
    if not named:
        said = {name: Named(None, said[name].unit, None) for name in table}
    thin = {name: values[: GUESSES.guessed_rows] for name, values in table.items()}
    found: dict[str, Guess] = {}
    for name, what in sorted(said.items(), key=lambda one: _asked_effort(one[1])):
        if what.role is not None:
            found[name] = Guess(name, what.role, what.index, what.unit, "by its name")
    _counts_between(thin, found)
    _twins(thin, found)
    _ranges_that_follow(thin, found)
    _measured_distance(found)
    _distance_of_an_axis(thin, found)
    _time(thin, said, found)
    nothing = not MOTIONS & {guess.role for guess in found.values()}
    by_numbers = by_values if nothing or not named else partners
    copies = copies_of_others(thin, found)
    usable = {n: values for n, values in thin.items() if said[n].used and n not in copies}
    found |= {guess.source: guess for guess in by_numbers(usable, said, found)}
    found = _numbered(found)
    for name in ours.keys() & found.keys():
        found[name] = replace(found[name], index=ours[name].index)
    found = _calibration(found)
    return _unique(scored(usable | {n: thin[n] for n in found}, said, found))


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


def _asked_effort(what: Named) -> bool:
    """Whether it is an effort that was asked for: one that was measured comes first."""
    return what.role == "effort" and what.asked


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


def _counts_between(table: Mapping[str, FloatArray], found: dict[str, Guess]) -> None:
    """Counts by which a command and a reading lie apart are no steps: droop pulses."""
    movers = [name for name, guess in found.items() if guess.role in LETTERED]
    if len(movers) > GUESSES.few_columns:
        return
    error = difference(table, movers)
    if error is not None and found[error].role == "steps":
        del found[error]


def _twins(table: Mapping[str, FloatArray], found: dict[str, Guess]) -> None:
    """Counts named as a command's but for the stem are what came of it: cmd_counts, pos_counts."""
    asked = [name for name, guess in found.items() if guess.role == "command"]
    for name, guess in list(found.items()):
        stem, _, end = name.rpartition("_")
        if guess.role != "steps" or read_name(stem).role != "position":
            continue
        for twin in asked:
            if twin.rpartition("_")[2] == end and same_range(table[name], table[twin]):
                found[name] = replace(guess, role="position", why=f"named and ranging as {twin}")


def _measured_distance(found: dict[str, Guess]) -> None:
    """What was measured beside a true distance, and followed no command, is a range."""
    roles = [guess.role for guess in found.values()]
    if {"command", "steps", "range"} & set(roles) or "distance" not in roles:
        return
    for name, guess in found.items():
        if guess.role == "position" and roles.count("position") == 1:
            found[name] = replace(guess, role="range", why="by its name, beside a true distance")


def _distance_of_an_axis(table: Mapping[str, FloatArray], found: dict[str, Guess]) -> None:
    """The only distance beside a command that it goes with is what an axis answered."""
    asked = [name for name, guess in found.items() if guess.name == "command"]
    seen = [name for name, guess in found.items() if guess.name in ("distance", "range")]
    if len(asked) != 1 or len(seen) != 1 or "position" in {one.role for one in found.values()}:
        return
    if correlation(table[asked[0]], table[seen[0]]) >= GUESSES.alike:
        why = f"by its name, and it follows {asked[0]}"
        found[seen[0]] = replace(found[seen[0]], role="position", why=why)


def _ranges_that_follow(table: Mapping[str, FloatArray], found: dict[str, Guess]) -> None:
    """A distance without a range that goes with it, where other columns move, is no true one."""
    far = [name for name, guess in found.items() if guess.role == "distance"]
    near = [name for name in table if name not in far and np.nanstd(table[name]) > 0.0]
    for name in far:
        if not any(abs(correlation(table[name], table[n])) >= GUESSES.alike for n in near):
            del found[name]


def _time(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: dict[str, Guess]
) -> None:
    """The one time column: named so, or the evenest of those that only increase.

    One that is named so may fail to increase in a few rows, which are mistakes.
    """
    named = [name for name, guess in found.items() if guess.role == "t"]
    named.sort(key=lambda name: "log_time" in name)  # a stamp of the sender's says more
    parts = "segment" in {guess.role for guess in found.values()}
    good = [name for name in named if rising(table[name])]
    good = good or [name for name in named if parts and starts_again(table[name])]
    good = good or [name for name in named if seldom_back(table[name])]
    if not good:
        even = {name: unevenness(one) for name, one in table.items() if rising(one)}
        good = sorted(
            (n for n in even if n not in found), key=lambda n: (counts(table[n]), even[n])
        )
        first = next(iter(table), "")
        if not good and even.get(first, 1.0) < GUESSES.clockwork and len(table) > len(even) + 1:
            good = [first]
    for name in named:
        del found[name]
    if good:
        name = good[0]
        why = ALONE if said[name].unit is None else f"{ALONE}, in {said[name].unit}"
        why = "by its name" if name in named else why
        found[name] = Guess(name, "t", None, said[name].unit, why)


def _numbered(found: dict[str, Guess]) -> dict[str, Guess]:
    """Numbers 0 to 2 become 1 to 3; single axes lose theirs; three arms are measured as theta."""
    zero = any(guess.index == "0" for guess in found.values())
    for name, guess in found.items():
        index, role = guess.index, guess.role
        if index in ("0", "1", "2") and zero:
            index = str(int(index) + 1)
        found[name] = replace(guess, index=index, role=role)
    motors = {g.index for g in found.values() if g.index in ("1", "2", "3")}
    places = {g.index for g in found.values() if g.role == "position"} >= set("xyz")
    for name, guess in found.items():
        index, role = guess.index, guess.role
        if places and role == "position" and index in ("x", "y", "z"):
            role = "pos"
        if role in ("command", "steps", "position", "effort", "velocity") and len(motors) < 2:
            index = "1" if role == "steps" else None
        if role == "position" and index in ("1", "2", "3"):
            role = "theta"
        if role == "position" and index in ("x", "y", "z"):
            role = "pos"
        found[name] = replace(guess, index=index, role=role)
    if any(guess.role == "steps" for guess in found.values()):
        for name, guess in found.items():
            if guess.role == "position" and guess.index is None:
                found[name] = replace(guess, role="theta", index="1")
    return found


CALIBRATES = "no command is there, and it says where the platform was to be"


def _calibration(found: dict[str, Guess]) -> dict[str, Guess]:
    """Angles of three arms beside places of the platform, without commands, take their part."""
    there = {guess.name for guess in found.values()}
    arms, places = {f"theta_{n}" for n in (1, 2, 3)}, {f"pos_{axis}" for axis in "xyz"}
    if not there >= arms | places or {"command_1", "steps_1"} & there:
        return found
    return {
        name: replace(one, role="command", why=f"{one.why}; {CALIBRATES}")
        if one.role == "theta"
        else one
        for name, one in found.items()
    }


def _unique(found: dict[str, Guess]) -> dict[str, Guess]:
    """The first of columns that would be the same."""
    first: dict[str, Guess] = {}
    for guess in found.values():
        if guess.name not in {kept.name for kept in first.values()}:
            first[guess.source] = guess
    return first


COMMANDED = ("command", "position")


def kind_of(
    guesses: Mapping[str, Guess], left: Sequence[str], constant: Iterable[str] = ()
) -> tuple[str | None, str | None, str]:
    """Kind of machine, linear or rotary, and why.

    left: columns that nothing is known of. constant: what has one value in all rows.
    """
    there = {guess.name for guess in guesses.values()} | {*constant}
    units = {
        guess.unit for guess in guesses.values() if guess.role in ("command", "position", "theta")
    }
    motion = "rotary" if units & set(ROTARY) else "linear" if units & set(LINEAR) else None
    calibrated = [one for one in guesses.values() if one.why.endswith(CALIBRATES)]
    if calibrated:
        return "delta", None, "angles of three arms, and where the platform was: a calibration"
    if there >= {"steps_2", "steps_3"} or there >= {"command_2", "command_3"}:
        return "delta", None, "commands of three motors"
    if "steps_1" in there and {"theta_1", "position"} & there:
        return "stepper_axis", None, "a count of steps, and the angle that came of it"
    if {"range", "distance"} <= there and not {"command", "effort"} & there:
        return "range_sensor", None, "distances, true and reported"
    if {"position", "theta_1"} & there and {"command", "effort"} & there:
        asked = " and ".join(sorted({"command", "effort"} & there))
        return "servo_axis", motion, f"{asked} in, position out"
    return None, motion, f"not enough is known: {_lacking(guesses, left)}"


def _lacking(guesses: Mapping[str, Guess], left: Sequence[str]) -> str:
    """What is needed besides, and how it is said; `left`: columns that nothing is known of."""
    here = "here too:"
    if {"pos_x", "pos_y", "pos_z"} <= {guess.name for guess in guesses.values()}:
        return (
            "places of a platform were found, and no angles or steps of its three motors beside"
            f" them; say which columns these are, {here} --set command_1=COLUMN, or steps_1, to 3"
        )
    named = {guess.name: guess.source for guess in guesses.values()}
    position = named.get("position")
    if position is None and "range" in named:
        return (
            "the true distance was not found; say which column it is, or the distance in m where it"
            f" is one for all rows, {here} --set distance=0.5"
        )
    if position is None:
        likely = next((one for one in left if read_name(one).used and not pulls(one)), None)
        name = without_unit(likely or "COLUMN")
        asked, read = (shlex.join(["--set", f"{role}={name}"]) for role in ("position", "range"))
        return (
            f"a position or a reading was not found; say which column it is, {here} {asked}, or of"
            f" a distance sensor {read}"
        )
    twin = next((one for one in left if read_name(one).unit in (*LINEAR, *ROTARY)), None)
    if twin is not None:
        names = [without_unit(one) for one in (position, twin)]
        asked, read = (f"{role}={one}" for role, one in zip(COMMANDED, names, strict=True))
        return (
            f"{' and '.join(names)} both look like positions; say which was commanded and which was"
            f" read, {here} {shlex.join(['--set', asked, '--set', read])}"
        )
    likely = next((one for one in left if pulls(one)), left[0] if left else "COLUMN")
    name = without_unit(likely)
    example = shlex.join(["--set", f"effort={name}"])
    counts = (
        "" if pulls(likely) else f"; or, if it counts steps, --set {shlex.quote(f'steps_1={name}')}"
    )
    return f"a command or an effort was not found; say which column it is, {here} {example}{counts}"


def zero_of(guesses: Mapping[str, Guess], table: Mapping[str, FloatArray]) -> str | None:
    """Whether command and reading of an axis share their zero."""
    by_name = {guess.name: guess for guess in guesses.values()}
    for asked, seen in (("command", "position"), ("command_1", "theta_1")):
        if asked not in by_name or seen not in by_name:
            continue
        one, other = by_name[asked], by_name[seen]
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


def may_be_asked(guesses: Mapping[str, Guess], table: Mapping[str, FloatArray]) -> list[str]:
    """A word of an effort that looks like the command of a position without one.

    u is what a controller gives, in the books the effort and in many a log what was asked for.
    """
    by_name = {guess.name: guess for guess in guesses.values()}
    effort, seen = by_name.get("effort"), by_name.get("position") or by_name.get("theta_1")
    if effort is None or seen is None or effort.why != BY_NAME or ASKED & by_name.keys():
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


def from_outside(
    guesses: Mapping[str, Guess], table: Mapping[str, FloatArray]
) -> tuple[dict[str, Guess], list[str]]:
    """Guesses in which a torque that no drive gives is a load, and a word of what it was taken for.

    guesses: by column. table: columns, name -> (n,).
    """
    by_name = {guess.name: guess for guess in guesses.values()}
    effort, seen = by_name.get("effort"), by_name.get("position")
    if effort is None or seen is None or "command" not in by_name or "load" in by_name:
        return dict(guesses), []
    if effort.why == "as you say" or not may_be_outside(effort.source):
        return dict(guesses), []
    if not _nothing_in_motion(table[effort.source], table[seen.source]):
        instead = "in place of effort in the printed command"
        return dict(guesses), [Hint(OF_THE_DRIVE, "name", effort.source, "load", instead)]
    load = replace(effort, role="load", why="it is 0 while the axis moves fastest")
    instead = "in place of load in the printed command"
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
