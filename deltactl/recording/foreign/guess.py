"""Which column is what: from names where there are any, from the numbers where there are none."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from deltactl.recording.foreign.by_values import by_values, partners
from deltactl.recording.foreign.names import Guess, Named, of_contract, read_name
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.ranking import ranked
from deltactl.recording.foreign.shapes import (
    copies_of_others,
    rising,
    same_range,
    starts_again,
    unevenness,
)
from deltactl.recording.format.edges import MOTORS
from deltactl.recording.reading.columns import FloatArray
from deltactl.recording.tables.flat import BESIDE, UNITS
from deltactl.recording.tables.moment import seldom_back

MOTIONS = frozenset({"position", "command", "steps", "range", "distance"})
LETTERED = frozenset({"position", "command", "steps"})
"""What motors a, b and c have; letters after a current may as well be its phases."""
OURS = frozenset(name for name in UNITS if name.rpartition("_")[0] in ("status", "disturbance")) | {
    "t_pwm"
}
"""Columns of the contract in whose names words stand that mean something else elsewhere."""
CURRENTS = frozenset(f"current_{motor}" for motor in range(1, MOTORS + 1))
"""The same where all are there; one alone is the effort of an axis."""
_LETTER = re.compile(r"(.+[_ .-])([a-cA-C])")


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
    thin = _thinned(table)
    found: dict[str, Guess] = {}
    for name, what in sorted(said.items(), key=lambda one: _asked_effort(one[1])):
        if what.role is not None:
            found[name] = Guess(name, what.role, what.index, what.unit, "by its name")
    _twins(thin, found)
    _measured_distance(found)
    _time(thin, said, found)
    nothing = not MOTIONS & {guess.role for guess in found.values()}
    by_numbers = by_values if nothing or not named else partners
    copies = copies_of_others(thin, found)
    usable = {n: values for n, values in thin.items() if said[n].used and n not in copies}
    found |= {guess.source: guess for guess in by_numbers(usable, said, found)}
    found = _numbered(found)
    for name in ours.keys() & found.keys():
        found[name] = replace(found[name], index=ours[name].index)
    return _unique(ranked(thin, said, found))


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


def of_other_joints(names: Iterable[str], found: Mapping[str, Guess]) -> list[str]:
    """Names of columns that are commands as well, of joints without numbers: shoulder, elbow."""
    if not any(guess.name == "command" for guess in found.values()):
        return []
    return [one for one in names if one not in found and read_name(one).role == "command"]


def _letters(names: list[str]) -> dict[str, str]:
    """How each name is read: soll_A, soll_B and soll_C are three motors, and no amperes."""
    ends = {name: _LETTER.fullmatch(name) for name in names}
    stems = [end[1] for end in ends.values() if end]
    return {
        name: f"{end[1]}{'abc'.index(end[2].lower()) + 1}"
        if end and stems.count(end[1]) == MOTORS and read_name(f"{end[1]}1").role in LETTERED
        else name
        for name, end in ends.items()
    }


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


def _thinned(table: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    return {name: values[: GUESSES.guessed_rows] for name, values in table.items()}


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
        free = [name for name in table if name not in found and rising(table[name])]
        good = sorted(free, key=lambda name: unevenness(table[name]))
    for name in named:
        del found[name]
    if good:
        name = good[0]
        why = "by its name" if name in named else "it alone increases all the way"
        found[name] = Guess(name, "t", None, said[name].unit, why)


def _numbered(found: dict[str, Guess]) -> dict[str, Guess]:
    """Numbers 0 to 2 become 1 to 3; lone axes lose theirs; three arms are measured as theta."""
    zero = any(guess.index == "0" for guess in found.values())
    for name, guess in found.items():
        index, role = guess.index, guess.role
        if index in ("0", "1", "2") and zero:
            index = str(int(index) + 1)
        found[name] = replace(guess, index=index, role=role)
    motors = {g.index for g in found.values() if g.index in ("1", "2", "3")}
    for name, guess in found.items():
        index, role = guess.index, guess.role
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


def _unique(found: dict[str, Guess]) -> dict[str, Guess]:
    """Of columns that would be the same, the first."""
    first: dict[str, Guess] = {}
    for guess in found.values():
        if guess.name not in {kept.name for kept in first.values()}:
            first[guess.source] = guess
    return first
