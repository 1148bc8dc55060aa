"""What the numbers of a column look like, and how two columns move beside each other."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping

import numpy as np

from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.units import UNIT_FACTORS
from deltactl.recording.reading.run import FloatArray

Table = Mapping[str, FloatArray]
"""Columns by name, shape (n,) each."""


def rising(values: FloatArray) -> bool:
    """Whether values only increase."""
    return len(values) > 2 and bool(np.isfinite(values).all() and (np.diff(values) > 0.0).all())


def never_falls(values: FloatArray) -> bool:
    """Whether values increase or rest, as what adds up: charge that was used, a way in all."""
    return bool((np.diff(values[np.isfinite(values)]) >= 0.0).all())


def counts(values: FloatArray) -> bool:
    """Whether each row has the number after the one before: a number of the row."""
    return bool((np.diff(values) == 1.0).all())


def same_range(one: FloatArray, other: FloatArray) -> bool:
    """Whether most of the wider of two ranges is common to both."""
    low, high = np.nanmin([one, other], axis=1), np.nanmax([one, other], axis=1)
    return bool(high.min() - low.max() > 0.5 * (high.max() - low.min()))


def starts_again(values: FloatArray) -> bool:
    """Whether values increase but for a few returns to where they began: runs, one by one."""
    back = np.flatnonzero(np.diff(values) <= 0.0)
    few = 0 < len(back) < GUESSES.most_runs * len(values)
    return few and bool(np.allclose(values[back + 1], values[0], atol=1e-3))


def copies_of_others(table: Table, known: Collection[str]) -> set[str]:
    """Columns without a role that hold in every row what an earlier column holds.

    A reading is late and has noise: what equals its command everywhere is the command once more.
    """
    copies: set[str] = set()
    for one, other in itertools.combinations(table, 2):
        moves = float(np.nanmax(table[one]) - np.nanmin(table[one])) > 0.0
        if other not in known and moves and np.array_equal(table[one], table[other], True):
            copies.add(other)
    return copies


def repeats(one: FloatArray, other: FloatArray) -> bool:
    """Whether two columns are one motion in two units, to the last digit of the coarser one."""
    if abs(correlation(one, other)) < GUESSES.alike:
        return False
    known = np.isfinite(one) & np.isfinite(other)
    a, b = one[known], other[known]
    per_one = float(np.polyfit(a, b, 1)[0])
    left = b - b.mean() - per_one * (a - a.mean())
    step = max(_least_step(b), abs(per_one) * _least_step(a))
    return bool(np.max(np.abs(left)) <= step)


def _least_step(values: FloatArray) -> float:
    """The smallest distance between two different readings of a column."""
    alike = GUESSES.same_reading * float(np.ptp(values))
    apart = np.diff(np.unique(values))
    return float(np.min(apart[apart > alike]))


def concordance(one: FloatArray, other: FloatArray) -> float:
    """How nearly two columns hold the same numbers, 0 to 1 (Lin 1989)."""
    known = np.isfinite(one) & np.isfinite(other)
    a, b = one[known], other[known]
    if len(a) < GUESSES.fewest_in_common:
        return 0.0
    wide = float(np.var(a) + np.var(b) + (a.mean() - b.mean()) ** 2)
    return max(2.0 * float(np.mean((a - a.mean()) * (b - b.mean()))) / max(wide, 1e-300), 0.0)


def unevenness(values: FloatArray) -> float:
    steps = np.diff(values)
    return float(np.std(steps) / np.mean(steps))


def correlation(one: FloatArray, other: FloatArray) -> float:
    both = np.isfinite(one) & np.isfinite(other)
    a, b = one[both], other[both]
    if len(a) < GUESSES.fewest_in_common or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def follows(values: FloatArray, drivers: list[FloatArray]) -> bool:
    """Whether a column is nearly a smooth function of others, by squares and products of them."""
    known = np.isfinite(values) & np.isfinite(drivers).all(axis=0)
    at = [driver[known] / max(float(np.ptp(driver[known])), 1e-300) for driver in drivers]
    pairs = itertools.combinations_with_replacement(at, 2)
    shapes = np.stack([np.ones(len(at[0])), *at, *(one * other for one, other in pairs)], axis=1)
    left = len(shapes) - shapes.shape[1]
    seen = values[known]
    if left < GUESSES.fewest_in_common or np.ptp(seen) == 0.0:
        return False
    missed = seen - shapes @ np.linalg.lstsq(shapes, seen, rcond=None)[0]
    share = 1.0 - float(missed @ missed) / left / float(np.var(seen))
    return bool(share > GUESSES.alike**2)


def roughness(values: FloatArray) -> float:
    """Size of second differences against the whole movement."""
    known = values[np.isfinite(values)]
    return float(np.std(np.diff(known, 2)) / np.std(known)) if len(known) > 3 else np.inf


def lead(one: FloatArray, other: FloatArray) -> tuple[int, float]:
    """By how many samples the first is ahead of the second, by the best correlation; and that."""
    one, other = one[: GUESSES.led_rows], other[: GUESSES.led_rows]
    best, where, most = correlation(one, other), 0, min(GUESSES.longest_lead, len(one) // 4)
    for shift in sorted(range(-most, most + 1), key=abs):
        a = one[max(0, -shift) : len(one) - max(0, shift)]
        b = other[max(0, shift) : len(other) - max(0, -shift)]
        likeness = correlation(a, b)
        if likeness > best + 1e-9:
            best, where = likeness, shift
    return where, max(best, 0.0)


def follows_step(one: FloatArray, other: FloatArray) -> float:
    """How much two columns move alike, 0 to 1; where one rests in turns, the other is compared as
    late as it follows. No delay is tried for two smooth columns, as a position and its slope are
    alike a quarter of a wave apart.
    """
    alike = max(correlation(one, other), 0.0)
    if alike >= GUESSES.alike or is_stepwise(one) == is_stepwise(other):
        return alike
    ahead, later = lead(one, other) if is_stepwise(one) else lead(other, one)
    return later if ahead > 0 else alike


def asks(one: FloatArray, other: FloatArray) -> bool:
    """Whether the first of two motions was asked for: whole counts, less noise, or earlier."""
    if is_count(one) != is_count(other):
        return is_count(one)
    if is_stepwise(one) != is_stepwise(other):
        return is_stepwise(one)
    ahead, _ = lead(one, other)
    if ahead != 0:
        return ahead > 0
    return roughness(one) <= roughness(other)


def is_whole(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return bool((known == np.round(known)).all())


def is_count(values: FloatArray) -> bool:
    return is_whole(values) and float(np.nanmax(values) - np.nanmin(values)) > GUESSES.large_count


def is_label(values: FloatArray) -> bool:
    """Few whole numbers that never fall: the number of a run."""
    known = values[np.isfinite(values)]
    steps = np.diff(known)
    few = (known == np.round(known)).all() and (steps >= 0).all() and not (steps > 0).all()
    return bool(few and known[0] in (0.0, 1.0))


def is_flag(values: FloatArray) -> bool:
    """Whether it is on or off and nothing else."""
    return bool(np.isin(values[np.isfinite(values)], (0.0, 1.0)).all())


def difference(table: Table, names: list[str]) -> str | None:
    """The column that is by how much two others lie apart, as the error of an axis; the smallest,
    as of a sum each part is such a column too.
    """
    found = [
        name
        for name, one, other in itertools.permutations(names, 3)
        if np.nanstd(table[name] - (table[one] - table[other]))
        < GUESSES.same_difference * np.nanstd(table[name])
    ]
    return min(found, key=lambda name: float(np.nanstd(table[name])), default=None)


def is_stepwise(values: FloatArray) -> bool:
    """Whether it mostly rests and jumps between."""
    changes = np.diff(values[np.isfinite(values)]) != 0.0
    return 0.0 < float(changes.mean()) < GUESSES.mostly_still


def rests_at_what_is_read(one: FloatArray, other: FloatArray) -> bool:
    """Whether the first is in few places, several rows in each, and the second reads these places
    in the same unit.
    """
    known = one[np.isfinite(one)]
    few = len(np.unique(known)) < GUESSES.few_places * len(known)
    rests = float((np.diff(known) == 0.0).mean()) > 0.5
    wide, told = (float(np.nanmax(values) - np.nanmin(values)) for values in (one, other))
    near = abs(told / max(wide, 1e-300) - 1.0) < GUESSES.near_unit
    return few and rests and near and same_range(one, other)


def pairs_alike(table: Table, names: list[str]) -> Iterator[tuple[str, str]]:
    """Columns two by two that move alike, what was asked for first; each column once.

    They go as far, or one is another unit of the other, and among many columns they share their
    range: joints of an arm move alike as well. Those that hold the same numbers come first: an
    effort may go with a command more closely than a late reading does.
    """
    alike = sorted(
        (
            (_agreement(table[a], table[b]), correlation(table[a], table[b]), a, b)
            for a, b in itertools.combinations(names, 2)
        ),
        reverse=True,
    )
    used: set[str] = set()
    pairs = []
    for _, likeness, a, b in alike:
        if likeness < GUESSES.alike or a in used or b in used:
            continue
        apart = len(table) > GUESSES.few_columns and not same_range(table[a], table[b])
        if not of_one_motion(table[a], table[b]) or apart:
            continue
        used |= {a, b}
        pairs.append((a, b) if asks(table[a], table[b]) else (b, a))
    order = {name: place for place, name in enumerate(names)}
    yield from sorted(pairs, key=lambda pair: order[pair[0]])


def _agreement(one: FloatArray, other: FloatArray) -> float:
    """Powers of ten of what two columns hold in common over what they do not, 0 where that is
    less than of one motion.
    """
    same = concordance(one, other)
    agrees = -float(np.log10(max(1.0 - same, 1e-9))) if same >= GUESSES.alike else 0.0
    return min(agrees, GUESSES.surest_fit)


def of_one_motion(one: FloatArray, other: FloatArray) -> bool:
    """Whether two motions go as far, or differ by a factor between units or by counts."""
    if is_count(one) != is_count(other):
        return True  # a step of a motor may be as small as any
    wide, told = (float(np.nanmax(values) - np.nanmin(values)) for values in (one, other))
    ratio = max(wide, told) / max(min(wide, told), 1e-300)
    return ratio < GUESSES.as_far or any(
        abs(ratio / factor - 1.0) < GUESSES.near_unit for factor in UNIT_FACTORS
    )


def slopes(table: Table, names: list[str], time: FloatArray) -> Iterator[tuple[str, str]]:
    """Columns that are the slope of another one, with that one."""
    used: set[str] = set()
    for name, of in itertools.permutations(names, 2):
        if name in used or of in used or is_stepwise(table[of]) or is_count(table[of]):
            continue
        if correlation(table[name], np.gradient(table[of], time)) > GUESSES.alike_slope:
            used |= {name}
            yield name, of
