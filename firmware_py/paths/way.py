"""Legs from point to point, straight, on arcs or on splines, with corners cut by no more than
is allowed.

At a corner that may not be cut, and at every dwell, the arms come to rest. Legs that go on
straight into each other (a spline always does) are passed without a stop.
"""

from __future__ import annotations

import math

import numpy as np

from deltactl.firmware_py.paths.corner import STRAIGHT_RAD, sampled, turns_rad, widest_m
from deltactl.firmware_py.paths.courses import Courses
from deltactl.firmware_py.paths.legs import Legs
from deltactl.firmware_py.paths.path import (
    BoolArray,
    Int64Array,
    Path,
    Space,
    interval_counts,
    line,
)
from deltactl.models.robot import FloatArray

MERGED = 0.05
"""Share of the corner distance for making short legs one: of 0.5 mm it takes up points that are
rounded to 0.01 mm, and stays below a microstep of most robots."""
NOTHING = 1e-3
"""Share of the spacing: less is what rounding leaves of a leg that two corners have used up."""
AT_ONCE = 2000
"""Legs sampled together: some MB, whatever the number of legs."""


def way(start_m: FloatArray, legs: Legs, corner_m: float, spacing_m: float) -> Path:
    """All legs one after another, sampled at most `spacing_m` apart."""
    kept = ends_of_lines(start_m, legs, MERGED * corner_m)
    legs = legs.rows(kept)
    courses = Courses(start_m, legs)
    turn_rad = turns_rad(courses)
    away_m = _cuts_m(courses, legs, turn_rad, corner_m * (1.0 - MERGED))
    left_m = np.concatenate([[0.0], away_m[:-1]])
    until_m = courses.length_m - away_m
    parts = [np.asarray(start_m, dtype=np.float64)[None, :]]
    sizes = np.zeros((len(legs), 2), dtype=np.int64)
    """Targets of each leg, and of the corner behind it."""
    for first in range(0, len(legs), AT_ONCE):
        some = np.arange(first, min(first + AT_ONCE, len(legs)))
        on_leg, sizes[some, 0] = _stretches(courses, some, left_m[some], until_m[some], spacing_m)
        cut = some[away_m[some] > 0.0]
        in_corner, sizes[cut, 1] = sampled(courses, cut, away_m[cut], turn_rad[cut], spacing_m)
        places = np.empty((len(on_leg) + len(in_corner), 3))
        of_corner = np.repeat(np.tile([False, True], len(some)), sizes[some].ravel())
        places[~of_corner], places[of_corner] = on_leg, in_corner
        parts.append(places)
    targets = np.concatenate(parts)
    rest, dwell_s = np.zeros(len(targets), dtype=np.bool_), np.zeros(len(targets))
    turns = np.concatenate([turn_rad > STRAIGHT_RAD, [True]])
    resting = np.flatnonzero((away_m <= 0.0) & (turns | (legs.dwell_s > 0.0)))
    ends = np.cumsum(sizes.ravel())[::2]  # target 0 is where the way begins
    rest[0], rest[ends[resting]] = True, True
    dwell_s[ends[resting]] = legs.dwell_s[resting]
    slowest_mps = np.minimum(legs.speed_mps, np.append(legs.speed_mps[1:], math.inf))
    speeds_mps = np.stack([legs.speed_mps, slowest_mps], axis=1).ravel()
    return Path(
        space=Space.CARTESIAN,
        targets=targets,
        dwell_s=dwell_s,
        rest=rest,
        way_back=line(targets[-1], targets[0], spacing_m)[1:-1],
        speed_mps=np.concatenate([[math.inf], np.repeat(speeds_mps, sizes.ravel())]),
        leg=np.concatenate([[0], np.repeat(kept, sizes.sum(axis=1))]),
    )


def way_target_count(start_m: FloatArray, legs: Legs, spacing_m: float) -> int:
    """About how many targets there are; corners that are cut make it a few fewer."""
    return 1 + int(interval_counts(Courses(start_m, legs).length_m, spacing_m).sum())


def _cuts_m(courses: Courses, legs: Legs, turn_rad: FloatArray, corner_m: float) -> FloatArray:
    """How long before its end each leg is left by a corner's curve, (n,); 0 where none is cut."""
    away_m = np.zeros(len(legs))
    if corner_m <= 0.0:
        return away_m
    corners = np.flatnonzero((turn_rad > STRAIGHT_RAD) & (legs.dwell_s[:-1] == 0.0))
    away_m[corners] = widest_m(courses, corners, turn_rad[corners], corner_m)
    used_m, fitting_m = 0.0, away_m.tolist()
    for leg, length_m in enumerate(courses.length_m.tolist()):
        used_m = fitting_m[leg] = min(fitting_m[leg], length_m - used_m)
    return np.array(fitting_m)


def _stretches(
    courses: Courses, legs: Int64Array, from_m: FloatArray, to_m: FloatArray, spacing_m: float
) -> tuple[FloatArray, Int64Array]:
    """Points of stretches of legs (k,) but for the first of each, and how many each has, (k,).

    None where nothing is left of a leg.
    """
    pieces = interval_counts(to_m - from_m, spacing_m)
    pieces[(to_m - from_m <= NOTHING * spacing_m) & (from_m > 0.0)] = 0
    row = np.repeat(np.arange(len(legs)), pieces)
    number = 1 + np.arange(len(row)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    run_m = from_m[row] + number / pieces[row] * (to_m - from_m)[row]
    last = number == pieces[row]
    run_m[last] = to_m[row[last]]
    return courses.at(legs[row], run_m), pieces


LONGEST_RUN = 1000
"""Legs looked at together: a line of more is as good in two."""
KNOWN = 8
"""Up to so many it is worked out for all legs at once whether they are one line."""


def ends_of_lines(start_m: FloatArray, legs: Legs, within_m: float) -> Int64Array:
    """Numbers of legs that are left, (k,), where runs of short straight ones are made one.

    Points in between are then no further from it than `within_m`; a dwell, another speed, and a
    turn back end a run. So a curve given by many points is not bent at each by their rounding,
    and a corner may reach over more than the last of the points before it.
    """
    if within_m <= 0.0:
        return np.arange(len(legs))
    kept: list[int] = []
    places = np.concatenate([np.asarray(start_m)[None], legs.to_m])
    ends, lines = _plain_runs(legs).tolist(), Lines(places, within_m)
    number = 0
    while number < len(legs):
        run = min(ends[number] - number, LONGEST_RUN)
        number += lines.longest(number, run)
        kept.append(number - 1)
    return np.array(kept)


def _plain_runs(legs: Legs) -> Int64Array:
    """For each leg, (n,), the one behind the last that is straight and as fast, without a rest
    before it."""
    plain = ~(legs.is_arc | legs.spline)
    goes_on = plain[:-1] & plain[1:] & (legs.dwell_s[:-1] == 0.0)
    goes_on &= legs.speed_mps[:-1] == legs.speed_mps[1:]
    behind = np.append(np.flatnonzero(~goes_on) + 1, len(legs))
    return np.repeat(behind, np.diff(behind, prepend=0))


class Lines:
    """Which short legs between points (n + 1, 3) are one line, to within a distance."""

    def __init__(self, points: FloatArray, within_m: float):
        self._points, self._within_m = points, within_m
        self._known = {
            count: _are_lines(points, count, within_m).tolist() for count in range(2, KNOWN + 1)
        }

    def longest(self, first: int, most: int) -> int:
        """How many of at most so many legs, from one on, are one line.

        Every point in between is no further from that line than `within_m`, and every leg goes
        forward along it. At least one; found by doubling, so that a long line costs little.
        """
        good, bad = 1, most + 1
        while good < bad - 1:
            tried = min(2 * good, bad - 1) if bad == most + 1 else (good + bad) // 2
            if self._is_line(first, tried):
                good = tried
            else:
                bad = tried
        return good

    def _is_line(self, first: int, count: int) -> bool:
        if count in self._known:
            return bool(self._known[count][first])
        points = self._points[first : first + count + 1]
        return bool(_are_lines(points, count, self._within_m)[0])


def _are_lines(points: FloatArray, count: int, within_m: float) -> BoolArray:
    """Whether so many legs from each of the points (n + 1, 3) on are one line, (n + 1 - count,)."""
    starts = max(len(points) - count, 0)
    whole = points[count:] - points[:starts]
    length_m = np.linalg.norm(whole, axis=1)
    along = whole / np.where(length_m > 0.0, length_m, 1.0)[:, None]
    found: BoolArray = length_m > 0.0
    if count > KNOWN:  # few starts, and many points
        hops, out = np.diff(points, axis=0), points[1:-1] - points[0]
        away = out - np.outer(out @ along[0], along[0])
        near = np.einsum("ni,ni->n", away, away).max(initial=0.0) <= within_m**2
        return found & bool((hops @ along[0] > 0.0).all() and near)
    before_m = np.zeros(starts)
    for number in range(1, count + 1):
        out = points[number : number + starts] - points[:starts]
        run_m = np.einsum("ni,ni->n", out, along)
        away_m = np.linalg.norm(out - run_m[:, None] * along, axis=1)
        found &= (run_m > before_m) & ((away_m <= within_m) | (number == count))
        before_m = run_m
    return found
