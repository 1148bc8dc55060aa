"""What columns are by their numbers, where names say nothing, or not all of it."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Sequence

import numpy as np

from deltactl.recording.foreign.axis_columns import EARLIER, LIKE, Columns, share_of_both
from deltactl.recording.foreign.names import Guess
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import (
    Table,
    correlation,
    difference,
    follows,
    is_count,
    is_flag,
    is_label,
    is_stepwise,
    is_whole,
    pairs_alike,
    rests_at_what_is_read,
    roughness,
    slopes,
)
from deltactl.recording.format.messages import MOTORS
from deltactl.recording.reading.run import FloatArray

ASKED = frozenset({"command", "steps", "distance"})
"""What a reading is compared with."""
PARTNER = {"command": "position", "steps": "position", "distance": "range", "range": "distance"}
"""What is compared with each of these."""
LEFT = "what is left; may be another"


def by_values(columns: Columns) -> Iterator[Guess]:
    """Roles from shapes: three counts are a delta, anything else is an axis."""
    table, free = columns.table, columns.unknown()
    moving = [n for n in free if np.ptp(np.diff(table[n])) != 0.0]  # neither still nor a count
    if deltas := _three_motors(table, moving, free):
        yield from deltas
        return
    labels = [name for name in moving if is_label(table[name])]
    yield from (
        Guess(n, "segment", None, None, "few whole numbers, one after another") for n in labels
    )
    yield from _of_an_axis(columns, _less(moving, labels))


def _of_an_axis(columns: Columns, moving: list[str]) -> Iterator[Guess]:
    """Pairs that move alike are command and reading, slopes are velocities."""
    table, time = columns.table, columns.time()
    if len(moving) <= GUESSES.few_columns and (error := difference(table, moving)):
        moving = _less(moving, [error])
    speeds = {} if time is None else dict(slopes(table, moving, time))
    for velocity, of in speeds.items():
        yield columns.taken(velocity, "velocity", None, f"it is the slope of {of}")
    moving, with_slope = _less(moving, speeds), dict.fromkeys(speeds.values())
    pairs = list(pairs_alike(table, moving))
    pairs.sort(key=with_slope.keys().isdisjoint)  # currents move alike too, and have no velocity
    yield from _of_pairs(columns, pairs)
    rest = [n for n in _less(moving, list(itertools.chain(*pairs))) if not is_flag(table[n])]
    if not pairs:
        yield from _of_lone(columns, rest, list(with_slope))
    elif len(pairs) == 1 and rest:
        yield columns.taken(rest[0], "effort", None, LEFT)


def _less(names: Sequence[str], without: Collection[str]) -> list[str]:
    return [name for name in names if name not in without]


def _of_pairs(columns: Columns, pairs: list[tuple[str, str]]) -> Iterator[Guess]:
    """What two columns are that move alike; of more pairs than a delta has motors the first."""
    table = columns.table
    indices: Sequence[str | None] = ["1", "2", "3"] if len(pairs) == MOTORS else [None]
    for (asked, seen), index in zip(pairs, indices, strict=False):
        like, unit = LIKE.format(seen), columns.said[asked].unit
        role, seen_as, why = "command", "theta" if index else "position", f"{like}, {EARLIER}"
        places = len(pairs) == 1 and bool(table[asked].min() >= 0.0)
        if places and rests_at_what_is_read(table[asked], table[seen]):
            role, seen_as, why = "distance", "range", f"rests in turns, and {seen} reads the same"
        elif is_count(table[asked]) and not is_count(table[seen]):
            role, seen_as, why = "steps", "theta", f"whole numbers; {like}"
            index, unit = index or "1", None
        elif is_stepwise(table[asked]) and places:
            role, seen_as, why = "distance", "range", f"rests in turns; {like}"
        yield Guess(asked, role, index, unit, why)
        yield columns.taken(seen, seen_as, index, LIKE.format(asked))


def _of_lone(columns: Columns, rest: list[str], with_slope: list[str]) -> Iterator[Guess]:
    """Columns of which no two move alike: a position, and what it was asked or driven by."""
    table = columns.table
    steady = [n for n in rest if is_stepwise(table[n])][:1] if len(rest) > 1 else []
    others = _less(rest, steady)
    if not others:
        return
    known = [n for n in with_slope if n in others]
    place = min(known[:1] or others, key=lambda n: roughness(table[n]))
    if roughness(table[place]) > GUESSES.roughest:
        return
    why = "another column is its slope" if known else "the smoothest of the columns"
    yield columns.taken(place, "position", None, why)
    if steady:
        yield columns.taken(steady[0], "command", None, "it rests in turns")
        return
    for name in _less(others, [place])[:1]:
        goes = share_of_both(table[name], table[place]) > GUESSES.alike**2
        if known or len(rest) == 2 or goes:  # of two there is nothing else that it could be
            yield columns.taken(name, "effort", None, LEFT)


def _three_motors(table: Table, moving: list[str], free: list[str]) -> list[Guess]:
    """Three counts, and three readings that follow them: a delta. Empty where it is none."""
    counts = [name for name in moving if is_count(table[name])]
    if len(counts) != MOTORS:
        return []
    drivers = [table[name] for name in counts]
    others = [n for n in moving if not is_whole(table[n]) and follows(table[n], drivers)]
    if len(others) < 3:
        return []
    small = [n for n in _less(free, counts) if is_whole(table[n])]
    groups = (
        ("steps", "123", counts, "three columns of whole numbers"),
        ("range", "xyz", others[:3], "three readings beside three counts"),
        ("status", "xyz", small, "small whole numbers, three of them"),
    )
    return [
        Guess(name, role, index, None, why)
        for role, indices, names, why in groups
        if len(names) == 3
        for name, index in zip(names, indices, strict=True)
    ]


def partners(columns: Columns) -> Iterator[Guess]:
    """What moves like a column that is known by its name, and has no name itself: the reading of a
    command, the command of a reading, the range of a distance.
    """
    known, asked = columns.of("range")[:1], columns.of(*ASKED)
    if asked and not columns.of("position", "range"):
        known = asked
    elif asked or columns.of("effort"):
        return
    guesses = [columns.found[name] for name in known]
    for guess, name in _nearest(columns.table, guesses, columns.free()):
        role = PARTNER[guess.role]
        yield columns.taken(name, role, guess.index, LIKE.format(guess.source))


def _nearest(table: Table, known: list[Guess], free: list[str]) -> Iterator[tuple[Guess, str]]:
    """Each of the known columns with the free one that moves most like it; each column once."""
    alike = [
        (round(likeness, 3), -_apart(table[guess.source], table[name]), guess, name)
        for guess in known
        for name in free
        if name != guess.source
        and (likeness := correlation(table[guess.source], table[name])) >= GUESSES.alike
    ]
    used: set[str] = set()
    for _, _, guess, name in sorted(alike, key=lambda one: one[:2], reverse=True):
        if guess.source not in used and name not in used:
            used |= {guess.source, name}
            yield guess, name


def _apart(one: FloatArray, other: FloatArray) -> float:
    return float(np.nanmean(np.abs(one - other)))
