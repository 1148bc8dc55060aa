"""Which kind of machine a table is of, what it lacks to be one, and whether what is taken for an
effort is one.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from deltactl.recording.foreign.axis_columns import share_of_both
from deltactl.recording.foreign.guess import CALIBRATES
from deltactl.recording.foreign.mapping import as_option
from deltactl.recording.foreign.names import (
    BY_NAME,
    Guess,
    Taken,
    by_name,
    may_be_outside,
    of_role,
    pulls,
    read_name,
    without_unit,
)
from deltactl.recording.foreign.notes import Hint, Note
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import Table, concordance, correlation
from deltactl.recording.foreign.units import IN_SI, LINEAR, LONE, ROTARY
from deltactl.recording.reading.run import FloatArray


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
    _Kind("servo_axis", (PLACE, DRIVEN), "{} in, position out", "theta_2 theta_3"),
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
    error = next((n for n in left if _is_error(n)), None)
    if error is not None and len(named.keys() & {*LONE}) == 1:
        (asked,) = (without_unit(named[name].source) for name in LONE if name in named)
        return _in_place_of_an_error(asked, without_unit(error))
    if "position" in named:
        return _lacking_beside(named["position"].source, left)
    if "range" in named:
        return (
            "the true distance was not found; name its column, or, where it is one for all rows,"
            f" say how large it is: {HERE} --set 'distance=NUMBER[mm]' (or [m], [cm])"
        )
    likely = next((one for one in left if read_name(one).used and not pulls(one)), None)
    name = without_unit(likely or "COLUMN")
    asked, read = (shlex.join(["--set", f"{role}={name}"]) for role in ("position", "range"))
    return (
        f"a position or a reading was not found; name its column: {HERE} {asked}; of a distance"
        f" sensor, with {read} --set distance=COLUMN (or --set 'distance=NUMBER[mm]')"
    )


def _is_error(name: str) -> bool:
    """Whether a name is that of an error or a deviation in a unit of motion."""
    said = read_name(name)
    return not said.used and said.unit in (*LINEAR, *ROTARY)


def _in_place_of_an_error(asked: str, error: str) -> str:
    """What is needed in place of by how much each reading is off."""
    sets = shlex.join(["--set", f"command={asked}", "--set", "position=COLUMN"])
    return (
        f"{error} is no reading, but how far one is from {asked}; add a column of readings ({asked}"
        f" plus {error}), and name it: {HERE} {sets}"
    )


def _lacking_beside(position: str, left: Sequence[str]) -> str:
    """What is needed beside a position: a command or an effort."""
    twin = next((one for one in left if read_name(one).unit in (*LINEAR, *ROTARY)), None)
    if twin is not None:
        names = [without_unit(one) for one in (position, twin)]
        asked, read = (f"{role}={one}" for role, one in zip(LONE, names, strict=True))
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
        if any(guess.factor and not guess.factor.zero_known for guess in (one, other)):
            return "arbitrary"
        units = {one.unit, other.unit}
        if len(units) > 1 and not units <= {*LINEAR}:
            return None
        values, read = (table[of.source] * of.scale * IN_SI[of.unit or "1"] for of in (one, other))
        apart = abs(float(np.nanmedian(read - values)))
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
    "taken for an effort by its name; it goes where {} goes, over as much, and may be its"
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
    return [Note.on([effort.source], MAY_BE_ASKED.format(seen.source, shlex.quote(read)))]


def second_reading(guesses: Taken, table: Table) -> list[str]:
    """A word of a column that moves as the reading of an axis without a command does, such as that
    of a second encoder.
    """
    seen = by_name(guesses).get("position")
    if seen is None or (ASKED | {"effort"}) & by_name(guesses).keys() != {"effort"}:
        return []
    free = (n for n, values in table.items() if n not in guesses and read_name(n).used)
    alike = {n: concordance(table[n], table[seen.source]) for n in free}
    other = max(alike, key=lambda name: alike[name], default="")
    if alike.get(other, 0.0) < GUESSES.one_motion:
        return []
    asked, read = map(without_unit, (seen.source, other))
    sets = shlex.join(["--set", f"command={asked}", "--set", f"position={read}"])
    says = f"moves as {seen.source} does; to compare the two, {HERE} {sets}"
    return [Note.on([other], says)]


def from_outside(guesses: Taken, table: Table) -> tuple[dict[str, Guess], list[str]]:
    """Guesses in which a torque that no drive gives is a load, and a word of what it was taken for.

    guesses: by column. table: columns, name -> (n,).
    """
    guesses = _of_the_drive(guesses, table)
    named = by_name(guesses)
    effort, seen = named.get("effort"), named.get("position")
    if effort is None or seen is None or "command" not in named or "load" in named:
        return dict(guesses), []
    if effort.why == "as you say" or not may_be_outside(effort.source):
        return dict(guesses), []
    if not _nothing_in_motion(table[effort.source], table[seen.source]):
        instead = "put load in place of effort in the printed command"
        return dict(guesses), [Hint.of(OF_THE_DRIVE, "name", [effort.source], "load", instead)]
    load = replace(effort, role="load", why="it is 0 while the axis moves fastest")
    instead = "put effort in place of load in the printed command"
    hint = Hint.of(OF_A_LOAD, "name", [effort.source], "effort", instead)
    return {**guesses, effort.source: load}, [hint]


def _of_the_drive(guesses: Taken, table: Table) -> Taken:
    """Guesses in which a load without a unit that goes with the motion is what a drive gives, as
    servos report theirs; what was taken for that is none.
    """
    named = by_name(guesses)
    load, seen = named.get("load"), named.get("position")
    if load is None or seen is None or load.unit is not None or load.why != BY_NAME:
        return guesses
    share = share_of_both(table[load.source], table[seen.source])
    if share < GUESSES.least_share:
        return guesses
    others = {name: one for name, one in guesses.items() if one.role != "effort"}
    why = f"by its name; it goes with the motion ({share:.0%})"
    return {**others, load.source: replace(load, role="effort", why=why)}


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
