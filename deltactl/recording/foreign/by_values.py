"""What columns are by their numbers, where names say nothing, or not all of it; and which of
several columns it is that could be the same thing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from deltactl.recording.foreign.names import MEASURED, TORQUES, Guess, Named, in_words
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.shapes import (
    asks,
    correlation,
    difference,
    follows,
    is_count,
    is_flag,
    is_label,
    is_stepwise,
    is_whole,
    pairs_alike,
    roughness,
    slopes,
)
from deltactl.recording.format.messages import MOTORS
from deltactl.recording.reading.run import FloatArray

CURRENTS = frozenset(["current", "strom", "iq", "i_q", "courant", "corriente", "corrente", "amps"])


def ranked(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: Mapping[str, Guess]
) -> dict[str, Guess]:
    """The same guesses, of several commands or efforts of one axis the likeliest first.

    `why` says what its values do.
    """
    position = next((n for n, guess in found.items() if guess.role == "position"), None)
    if position is None:
        return dict(found)
    own = _of_one_joint(position, list(found))
    first: dict[str, Guess] = {}
    for role, rank in (("command", _command_rank), ("effort", _effort_rank)):
        several = [n for n, guess in found.items() if guess.role == role and guess.index is None]
        if len(several) < 2:
            continue
        ranks = {n: (n not in own, *rank(table, said, n, position)) for n in several}
        best = min(several, key=lambda name: ranks[name])
        share = -float(ranks[best][-1])
        does = "position follows it" if role == "command" else "it goes with the motion"
        why = (
            f"by its name; {does} ({share:.0%})" if share >= GUESSES.least_share else "by its name"
        )
        first[best] = replace(found[best], why=why)
    return first | {name: guess for name, guess in found.items() if name not in first}


def _of_one_joint(position: str, names: list[str]) -> set[str]:
    """Columns that begin as the position's name does, where several do: X_Position, X_Current."""
    begins = re.split(r"[^0-9A-Za-z]+", position)[0]
    return {name for name in names if re.split(r"[^0-9A-Za-z]+", name)[0] == begins} or set(names)


def _command_rank(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], name: str, position: str
) -> tuple[float, ...]:
    """Smaller is likelier; the last is minus the share of the position that follows it."""
    likeness = max(correlation(table[name], table[position]), 0.0)
    return (float(likeness**2 < GUESSES.least_share), -(likeness**2))


def _effort_rank(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], name: str, position: str
) -> tuple[float, ...]:
    """Smaller is likelier; the last is minus the share that goes with the motion."""
    words = set(in_words(name))
    kind = 0 if words & TORQUES else 1 if words & CURRENTS else 2
    share = _share_of_motion(table[name], table[position])
    asked = float(said[name].asked)
    unlikely = float(share < GUESSES.least_share)
    indirect = float(kind == 2)
    return (indirect, unlikely, asked, kind, float(not words & MEASURED), -share)


def _share_of_motion(effort: FloatArray, position: FloatArray) -> float:
    """Share of an effort's variance that acceleration, speed and its sign explain.

    Over several spans of rows, of which the best counts: noise of a position rules over few.
    """
    shares = [0.0]
    for rows in GUESSES.slope_rows:
        if len(position) < GUESSES.fewest_in_common * rows:
            break
        at = np.nan_to_num(position[::rows], nan=float(np.nanmean(position)))
        seen = effort[::rows]
        speed = np.gradient(at)
        shapes = np.stack([np.gradient(speed), speed, np.sign(speed), np.ones(len(at))], axis=1)
        known = np.isfinite(seen)
        left = len(seen[known]) - shapes.shape[1]
        spread = float(np.var(seen[known])) if left > 0 else 0.0
        if spread > 0.0:
            size = np.linalg.lstsq(shapes[known], seen[known], rcond=None)[0]
            missed = float(np.sum((seen[known] - shapes[known] @ size) ** 2)) / left
            shares.append(1.0 - missed / spread)
    return max(shares)


ASKED = frozenset({"command", "steps", "distance"})
"""What a reading is compared with."""
EARLIER = "smoother or earlier"
"""Why one of two columns that move alike is the command, where no name says it."""


def by_values(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: Mapping[str, Guess]
) -> Iterator[Guess]:
    """Roles from shapes: pairs that move alike are command and reading, slopes are velocities."""
    filled = [n for n in table if np.isfinite(table[n]).mean() > GUESSES.least_filled]
    free = [n for n in filled if n not in found]
    moving = [n for n in free if np.nanstd(table[n]) > 0.0]
    if deltas := _three_motors(table, moving, free):
        yield from deltas
        return
    for name in [n for n in moving if is_label(table[n])]:
        moving.remove(name)
        yield Guess(name, "segment", None, None, "few whole numbers, one after another")
    time = next((table[n] for n, guess in found.items() if guess.role == "t"), None)
    if len(moving) <= GUESSES.few_columns and (error := difference(table, moving)):
        moving.remove(error)
    speeds = [] if time is None else list(slopes(table, moving, time))
    for velocity, of in speeds:
        moving.remove(velocity)
        yield Guess(velocity, "velocity", None, said[velocity].unit, f"it is the slope of {of}")
    pairs = list(pairs_alike(table, moving))
    yield from _of_pairs(table, said, pairs)
    rest = [n for n in moving if n not in {name for pair in pairs for name in pair}]
    if not pairs:
        yield from _of_lone(table, said, rest, [of for _, of in speeds])
    elif len(pairs) == 1 and rest:
        yield Guess(rest[0], "effort", None, said[rest[0]].unit, "what is left; may be another")


def _of_pairs(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], pairs: list[tuple[str, str]]
) -> Iterator[Guess]:
    """What two columns are that move alike; of more pairs than a delta has motors the first."""
    indices: Sequence[str | None] = ["1", "2", "3"][: len(pairs)]
    if len(pairs) == 1 or len(pairs) > MOTORS:
        indices = [None]
    why = "moves like {}"
    for (asked, seen), index in zip(pairs, indices, strict=False):
        like = why.format(asked)
        if is_count(table[asked]) and not is_count(table[seen]):
            words = f"whole numbers; {why.format(seen)}"
            yield Guess(asked, "steps", index or "1", None, words)
            yield Guess(seen, "theta", index or "1", said[seen].unit, like)
        elif is_stepwise(table[asked]) and len(pairs) == 1 and table[asked].min() >= 0.0:
            words = f"stands still in turns; {why.format(seen)}"
            yield Guess(asked, "distance", None, said[asked].unit, words)
            yield Guess(seen, "range", None, said[seen].unit, like)
        else:
            words = f"{why.format(seen)}, {EARLIER}"
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
    rest = [n for n in rest if not is_flag(table[n])]
    if not rest:
        return
    steady = [n for n in rest if is_stepwise(table[n])][: len(rest) - 1]
    others = [n for n in rest if n not in steady[:1]]
    known = [n for n in with_slope if n in others]
    place = known[0] if known else min(others, key=lambda n: roughness(table[n]))
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
    """Three counts, and three readings that follow them: a delta. Empty where it is none."""
    counts = [name for name in moving if is_count(table[name])]
    others = [name for name in moving if not is_whole(table[name])]
    if len(counts) != 3:
        return []
    others = [name for name in others if follows(table[name], [table[n] for n in counts])]
    if len(others) < 3:
        return []
    found = [
        Guess(name, "steps", str(n + 1), None, "three columns of whole numbers")
        for n, name in enumerate(counts)
    ]
    found += [
        Guess(name, "range", axis, None, "three readings beside three counts")
        for name, axis in zip(others, "xyz", strict=False)
    ]
    small = [n for n in free if n not in counts and is_whole(table[n])]
    if len(small) == 3:
        found += [
            Guess(name, "status", axis, None, "small whole numbers, three of them")
            for name, axis in zip(small, "xyz", strict=True)
        ]
    return found


def partners(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], found: Mapping[str, Guess]
) -> Iterator[Guess]:
    """What moves like a column that is known by its name, and has no name itself: the reading of a
    command, the command of a reading, the range of a distance.
    """
    roles = {guess.role for guess in found.values()}
    free = _free(table, found)

    def of(*wanted: str) -> list[Guess]:
        return [guess for guess in found.values() if guess.role in wanted]

    if not roles & {"position", "range"} and roles & ASKED:
        for guess, name in _nearest(table, of(*ASKED), free):
            yield _read(guess, name, "range" if guess.role == "distance" else "position", said)
    elif not roles & {*ASKED, "effort"}:
        for guess, name in _nearest(table, of("range")[:1], free):
            yield _read(guess, name, "distance", said)
        seen = of("position")
        for guess, name in _nearest(table, seen, free + [one.source for one in seen[1:]]):
            yield from _asked_and_read(table, said, guess, name)


def _free(table: Mapping[str, FloatArray], found: Mapping[str, Guess]) -> list[str]:
    """Columns that move, and of which nothing is known."""
    return [
        name
        for name, values in table.items()
        if name not in found
        and np.isfinite(values).mean() > GUESSES.least_filled
        and np.nanstd(values) > 0.0
    ]


def _nearest(
    table: Mapping[str, FloatArray], known: list[Guess], free: list[str]
) -> Iterator[tuple[Guess, str]]:
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


def _read(known: Guess, name: str, role: str, said: Mapping[str, Named]) -> Guess:
    return Guess(name, role, known.index, said[name].unit, f"moves like {known.source}")


def _asked_and_read(
    table: Mapping[str, FloatArray], said: Mapping[str, Named], seen: Guess, other: str
) -> Iterator[Guess]:
    """Of two columns that move alike, which was asked for: the numbers alone tell."""
    first = asks(table[other], table[seen.source])
    asked, read = (other, seen.source) if first else (seen.source, other)
    role, why = "command", f"moves like {read}, {EARLIER}"
    if is_count(table[asked]) and not is_count(table[read]):
        role, why = "steps", f"whole numbers; moves like {read}"
    yield Guess(asked, role, seen.index, said[asked].unit, why)
    yield Guess(read, "position", seen.index, said[read].unit, f"moves like {asked}")
