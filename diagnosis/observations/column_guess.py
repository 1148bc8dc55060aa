"""Which column is what: from names where there are any, from the numbers where there are none."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.observations.column_names import Named, read_name
from diagnosis.observations.options import GUESSES
from diagnosis.observations.readings import FloatArray
from models.robot import ARMS

MOTIONS = frozenset({"position", "command", "steps", "range"})
LETTERED = frozenset({"position", "command", "steps"})
"""What motors a, b and c have; letters after a current may as well be its phases."""
_LETTER = re.compile(r"(.+[_ .-])([a-cA-C])")


@dataclass(frozen=True, slots=True)
class Guess:
    """A column of a file and what it is taken for; `why` says from what."""

    source: str
    role: str
    index: str | None
    unit: str | None
    why: str
    scale: float = 1.0
    """How much of `unit` one of the column is."""

    @property
    def name(self) -> str:
        """The column's name in the contract; velocity and others have none with a number."""
        return self.role if self.index is None else f"{self.role}_{self.index}"


def guess_columns(
    table: Mapping[str, FloatArray], units: Mapping[str, str], named: bool
) -> dict[str, Guess]:
    """A guess for each column that one could be made for, by its name in the file."""
    spelled = _letters(list(table))
    said = {name: read_name(spelled[name], units.get(name, "")) for name in table}
    if not named:
        said = {name: Named(None, said[name].unit, None) for name in table}
    thin = _thinned(table)
    found: dict[str, Guess] = {}
    for name, what in said.items():
        if what.role is not None:
            found[name] = Guess(name, what.role, what.index, what.unit, "by its name")
    _twins(thin, found)
    _measured_distance(found)
    _time(thin, said, found)
    if not named or not {"position", "command", "steps", "range"} & {
        g.role for g in found.values()
    }:
        for guess in _by_values(thin, said, found):
            found[guess.source] = guess
    return _unique(_numbered(found))


def _letters(names: list[str]) -> dict[str, str]:
    """How each name is read: soll_A, soll_B and soll_C are three motors, and no amperes."""
    ends = {name: _LETTER.fullmatch(name) for name in names}
    stems = [end[1] for end in ends.values() if end]
    return {
        name: f"{end[1]}{'abc'.index(end[2].lower()) + 1}"
        if end and stems.count(end[1]) == ARMS and read_name(f"{end[1]}1").role in LETTERED
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
            if twin.rpartition("_")[2] == end and _same_range(table[name], table[twin]):
                found[name] = replace(guess, role="position", why=f"named and ranging as {twin}")


def _measured_distance(found: dict[str, Guess]) -> None:
    """What was measured beside a true distance, and followed no command, is a range."""
    roles = [guess.role for guess in found.values()]
    if {"command", "steps", "range"} & set(roles) or "distance" not in roles:
        return
    for name, guess in found.items():
        if guess.role == "position" and roles.count("position") == 1:
            found[name] = replace(guess, role="range", why="by its name, beside a true distance")


def _same_range(one: FloatArray, other: FloatArray) -> bool:
    """Whether most of the wider of two ranges is common to both."""
    low, high = np.nanmin([one, other], axis=1), np.nanmax([one, other], axis=1)
    return bool(high.min() - low.max() > 0.5 * (high.max() - low.min()))


def rising(values: FloatArray) -> bool:
    """Whether values only increase."""
    return len(values) > 2 and bool(np.isfinite(values).all() and (np.diff(values) > 0.0).all())


def _starts_again(values: FloatArray) -> bool:
    """Whether values increase but for a few returns to where they began: runs, one by one."""
    back = np.flatnonzero(np.diff(values) <= 0.0)
    few = 0 < len(back) < GUESSES.most_runs * len(values)
    return few and bool(np.allclose(values[back + 1], values[0], atol=1e-3))


def _thinned(table: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    return {name: values[: GUESSES.guessed_rows] for name, values in table.items()}


def _time(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: dict[str, Guess]
) -> None:
    """The one time column: named so, or the evenest of those that only increase."""
    named = [name for name, guess in found.items() if guess.role == "t"]
    named.sort(key=lambda name: "log_time" in name)  # a stamp of the sender's says more
    parts = "segment" in {guess.role for guess in found.values()}
    good = [name for name in named if rising(table[name])]
    good = good or [name for name in named if parts and _starts_again(table[name])]
    if not good:
        free = [name for name in table if name not in found and rising(table[name])]
        good = sorted(free, key=lambda name: _unevenness(table[name]))
    for name in named:
        del found[name]
    if good:
        name = good[0]
        why = "by its name" if name in named else "it alone increases all the way"
        found[name] = Guess(name, "t", None, said[name].unit, why)


def _unevenness(values: FloatArray) -> float:
    steps = np.diff(values)
    return float(np.std(steps) / np.mean(steps))


def _by_values(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: Mapping[str, Guess]
) -> Iterator[Guess]:
    """Roles from shapes: pairs that move alike are command and reading, slopes are velocities."""
    filled = [n for n in table if np.isfinite(table[n]).mean() > GUESSES.least_filled]
    free = [n for n in filled if n not in found]
    moving = [n for n in free if np.nanstd(table[n]) > 0.0]
    if deltas := _three_motors(table, moving, free):
        yield from deltas
        return
    for name in [n for n in moving if _is_label(table[n])]:
        moving.remove(name)
        yield Guess(name, "segment", None, None, "few whole numbers, one after another")
    time = next((table[n] for n, guess in found.items() if guess.role == "t"), None)
    slopes = [] if time is None else list(_slopes(table, moving, time))
    for velocity, of in slopes:
        moving.remove(velocity)
        yield Guess(velocity, "velocity", None, said[velocity].unit, f"it is the slope of {of}")
    pairs = list(_pairs(table, moving))
    yield from _of_pairs(table, said, pairs)
    rest = [n for n in moving if n not in {name for pair in pairs for name in pair}]
    if not pairs:
        yield from _of_lone(table, said, rest, [of for _, of in slopes])
    elif len(pairs) == 1 and rest:
        yield Guess(rest[0], "effort", None, said[rest[0]].unit, "what is left; may be another")


def _of_pairs(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], pairs: list[tuple[str, str]]
) -> Iterator[Guess]:
    """What two columns are that move alike."""
    indices: list[str | None] = [None] if len(pairs) == 1 else ["1", "2", "3"]
    why = "moves like {}"
    for (asked, seen), index in zip(pairs, indices, strict=False):
        like = why.format(asked)
        if _is_count(table[asked]) and not _is_count(table[seen]):
            words = f"whole numbers; {why.format(seen)}"
            yield Guess(asked, "steps", index or "1", None, words)
            yield Guess(seen, "theta", index or "1", said[seen].unit, like)
        elif _is_stepwise(table[asked]) and len(pairs) == 1 and table[asked].min() >= 0.0:
            words = f"stands still in turns; {why.format(seen)}"
            yield Guess(asked, "distance", None, said[asked].unit, words)
            yield Guess(seen, "range", None, said[seen].unit, like)
        else:
            words = f"{why.format(seen)}, smoother or earlier"
            yield Guess(asked, "command", index, said[asked].unit, words)
            role = "position" if index is None else "theta"
            yield Guess(seen, role, index, said[seen].unit, like)


def _of_lone(
    table: Mapping[str, FloatArray],
    said: Mapping[str, Named],
    rest: list[str],
    with_slope: list[str],
) -> Iterator[Guess]:
    """Columns of which no two move alike: a position, and what it was asked or driven by."""
    if not rest:
        return
    steady = [n for n in rest if _is_stepwise(table[n])][: len(rest) - 1]
    others = [n for n in rest if n not in steady[:1]]
    known = [n for n in with_slope if n in others]
    place = known[0] if known else min(others, key=lambda n: _roughness(table[n]))
    why = "another column is its slope" if known else "the smoothest of the columns"
    yield Guess(place, "position", None, said[place].unit, why)
    others.remove(place)
    for name in steady[:1]:
        yield Guess(name, "command", None, said[name].unit, "it stands still in turns")
    for name in others[: 0 if steady else 1]:
        yield Guess(name, "effort", None, said[name].unit, "what is left; may be another")


def _three_motors(
    table: Mapping[str, FloatArray], moving: list[str], free: list[str]
) -> list[Guess]:
    """Three counts and three readings: a delta. Empty where it is none."""
    counts = [name for name in moving if _is_count(table[name])]
    others = [name for name in moving if not _is_whole(table[name])]
    if len(counts) != 3 or len(others) < 3:
        return []
    found = [
        Guess(name, "steps", str(n + 1), None, "three columns of whole numbers")
        for n, name in enumerate(counts)
    ]
    found += [
        Guess(name, "range", axis, None, "three readings beside three counts")
        for name, axis in zip(others, "xyz", strict=False)
    ]
    small = [n for n in free if n not in counts and _is_whole(table[n])]
    if len(small) == 3:
        found += [
            Guess(name, "status", axis, None, "small whole numbers, three of them")
            for name, axis in zip(small, "xyz", strict=True)
        ]
    return found


def _slopes(
    table: Mapping[str, FloatArray], names: list[str], time: FloatArray
) -> Iterator[tuple[str, str]]:
    """Columns that are the slope of another one, with that one."""
    used: set[str] = set()
    for name, of in itertools.permutations(names, 2):
        if name in used or of in used or _is_stepwise(table[of]) or _is_count(table[of]):
            continue
        if _correlation(table[name], np.gradient(table[of], time)) > GUESSES.alike_slope:
            used |= {name}
            yield name, of


def _pairs(table: Mapping[str, FloatArray], names: list[str]) -> Iterator[tuple[str, str]]:
    """Columns two by two that move alike, what was asked for first; each column once."""
    both = itertools.combinations(names, 2)
    alike = sorted(((_correlation(table[a], table[b]), a, b) for a, b in both), reverse=True)
    used: set[str] = set()
    pairs = []
    for likeness, a, b in alike:
        if likeness < GUESSES.alike or a in used or b in used:
            continue
        used |= {a, b}
        pairs.append((a, b) if _asks(table[a], table[b]) else (b, a))
    order = {name: place for place, name in enumerate(names)}
    yield from sorted(pairs, key=lambda pair: order[pair[0]])[:3]


def _asks(one: FloatArray, other: FloatArray) -> bool:
    """Whether the first of two motions was asked for: whole counts, less noise, or earlier."""
    if _is_count(one) != _is_count(other):
        return _is_count(one)
    if _is_stepwise(one) != _is_stepwise(other):
        return _is_stepwise(one)
    lead = _lead(one, other)
    if lead != 0:
        return lead > 0
    return _roughness(one) <= _roughness(other)


def _lead(one: FloatArray, other: FloatArray) -> int:
    """By how many samples the first is ahead of the second, by the best correlation."""
    best, where, most = -1.0, 0, GUESSES.longest_lead
    for shift in range(-most, most + 1):
        a = one[max(0, -shift) : len(one) - max(0, shift)]
        b = other[max(0, shift) : len(other) - max(0, -shift)]
        likeness = _correlation(a, b)
        if likeness > best + 1e-9:
            best, where = likeness, shift
    return where


def _correlation(one: FloatArray, other: FloatArray) -> float:
    both = np.isfinite(one) & np.isfinite(other)
    a, b = one[both], other[both]
    if len(a) < GUESSES.fewest_in_common or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def _roughness(values: FloatArray) -> float:
    """Size of second differences against the whole movement."""
    known = values[np.isfinite(values)]
    return float(np.std(np.diff(known, 2)) / np.std(known)) if len(known) > 3 else np.inf


def _is_whole(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return bool((known == np.round(known)).all())


def _is_count(values: FloatArray) -> bool:
    return _is_whole(values) and float(np.nanmax(values) - np.nanmin(values)) > GUESSES.large_count


def _is_label(values: FloatArray) -> bool:
    """Few whole numbers that never fall: the number of a run."""
    known = values[np.isfinite(values)]
    return bool(
        (known == np.round(known)).all() and (np.diff(known) >= 0).all() and known[0] in (0.0, 1.0)
    )


def _is_stepwise(values: FloatArray) -> bool:
    """Whether it mostly stands still and jumps between."""
    changes = np.diff(values[np.isfinite(values)]) != 0.0
    return 0.0 < float(changes.mean()) < GUESSES.mostly_still


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
