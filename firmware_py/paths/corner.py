"""Corners between two legs, cut: a curve leaves one and meets the other in its direction.

The curve is the cubic with both headings as its ends' tangents; between straight legs that is
the parabola whose middle is nearest to the corner. How early it leaves follows from how far it
may stray: in closed form between straight legs, by trial elsewhere. Corner n lies between legs n
and n + 1; all of a way are worked out together.
"""

from __future__ import annotations

import math

import numpy as np

from deltactl.firmware_py.paths.courses import Courses, interpolated, runs_of
from deltactl.firmware_py.paths.path import Int64Array, interval_counts
from deltactl.models.robot import FloatArray

STRAIGHT_RAD = math.radians(0.5)
"""Legs that meet at less than this go on into each other without a stop."""
TRIALS = 24
CLOSE = 1e-3
"""Share by which less may be cut than could be."""
SAMPLES = 129
KEPT = 0.999
"""Share of what may be cut that is used: between so many samples a curve strays a little further,
by less than a ten-thousandth in the worst of those that were tried."""
AT_ONCE = 200_000
"""Pairs of a point and a line looked at together: a few MB."""
NEWTON_STEPS = 12
MEASURED_AT = 201
MEASURED_AT_ONCE = 250
"""Corners whose curves are measured together: a few MB."""


def turns_rad(courses: Courses) -> FloatArray:
    """By how much the way turns at each corner, (n - 1,); half a turn where a leg has no length."""
    own = np.arange(len(courses) - 1)
    one = courses.headings(own, courses.length_m[:-1])
    other = courses.headings(own + 1, np.zeros(len(own)))
    turns: FloatArray = np.arccos(np.clip(np.einsum("ni,ni->n", one, other), -1.0, 1.0))
    turns[~one.any(axis=1) | ~other.any(axis=1)] = math.pi
    return turns


def widest_m(
    courses: Courses, corners: Int64Array, turn_rad: FloatArray, corner_m: float
) -> FloatArray:
    """How early before these corners, (k,), their curves may begin [m], and how late end.

    A curve then passes within `corner_m` of its corner, and is nowhere further from the legs; it
    uses no more than a leg before it, and half of the leg after it. turn_rad: at each, (k,).
    """
    room_m = np.minimum(courses.length_m[corners], 0.5 * courses.length_m[corners + 1])
    curved = courses.is_arc | courses.is_spline
    trial = np.flatnonzero((curved[corners] | curved[corners + 1]) & (room_m > 0.0))
    found: FloatArray = np.minimum(2.0 * corner_m / np.sin(turn_rad / 2.0), room_m)
    for first in range(0, len(trial), MEASURED_AT_ONCE):
        some = trial[first : first + MEASURED_AT_ONCE]
        found[some] = _tried(courses, corners[some], KEPT * corner_m, room_m[some])
    return found


def _tried(courses: Courses, corners: Int64Array, most_m: float, room_m: FloatArray) -> FloatArray:
    """The longest ways before corners, (k,), at which their curves still keep to the legs."""
    low, high = np.zeros(len(corners)), room_m.copy()
    at_low, at_high = low.copy(), _stray_m(courses, corners, room_m)
    low[at_high <= most_m] = room_m[at_high <= most_m]
    for trial in range(TRIALS):
        left = np.flatnonzero((high - low > CLOSE * high) & (at_low < (1.0 - CLOSE) * most_m))
        if not len(left):
            break
        part = 0.5 * np.ones(len(left))
        if trial % 3 < 2:  # nearly in proportion: where a straight line says, or a little less
            aim = most_m * (1.0 - CLOSE / 2.0)
            part = (aim - at_low[left]) / (at_high[left] - at_low[left])
            part = np.clip(part, 0.01, 0.99)
        middle = low[left] + part * (high[left] - low[left])
        strays = _stray_m(courses, corners[left], middle)
        good, bad = left[strays <= most_m], left[strays > most_m]
        low[good], at_low[good] = middle[strays <= most_m], strays[strays <= most_m]
        high[bad], at_high[bad] = middle[strays > most_m], strays[strays > most_m]
    return low


def sampled(
    courses: Courses,
    corners: Int64Array,
    away_m: FloatArray,
    turn_rad: FloatArray,
    spacing_m: float,
) -> tuple[FloatArray, Int64Array]:
    """Points of the curves as far apart as those of the legs, but for the first of each.

    Returns the points of all, (m, 3), one curve after another, and how many each has, (k,).
    """
    curved = courses.is_arc | courses.is_spline
    pieces = interval_counts(away_m * 2.0 * _run(np.ones(len(away_m)), turn_rad), spacing_m)
    measured = np.flatnonzero(curved[corners] | curved[corners + 1])
    drawn = _Curves(courses, corners, away_m)
    tables = np.empty((len(measured), MEASURED_AT))
    even = np.linspace(0.0, 1.0, MEASURED_AT)
    for first in range(0, len(measured), MEASURED_AT_ONCE):
        some = measured[first : first + MEASURED_AT_ONCE]
        places = drawn.at(np.repeat(some, MEASURED_AT), np.tile(even, len(some)))
        tables[first : first + len(some)] = runs_of(places.reshape(len(some), MEASURED_AT, 3))
    pieces[measured] = interval_counts(tables[:, -1], spacing_m)
    row = np.repeat(np.arange(len(corners)), pieces)
    number = 1 + np.arange(len(row)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    run = number / pieces[row]
    part = _parts(run, turn_rad[row])
    table_of = np.full(len(corners), -1)
    table_of[measured] = np.arange(len(measured))
    if len(looked_up := np.flatnonzero(table_of[row] >= 0)):
        table = table_of[row[looked_up]]
        column = interpolated(tables, table, tables[table, -1] * run[looked_up])
        part[looked_up] = column / (MEASURED_AT - 1)
    return drawn.at(row, part), pieces


def _run(off: FloatArray, turn_rad: FloatArray) -> FloatArray:
    """How long parabolas are from their middles to parts of their halves, (m,), 0 to 1.

    In the unit of how early before its corner each begins. The speed along one, over the
    parameter, is sqrt(cos^2 + off^2 sin^2) of half its turn.
    """
    sin, cos = np.sin(turn_rad / 2.0), np.maximum(np.cos(turn_rad / 2.0), 1e-9)
    slope = np.sqrt(cos**2 + (off * sin) ** 2)
    run: FloatArray = 0.5 * (off * slope + cos**2 / sin * np.arcsinh(off * sin / cos))
    return run


def _parts(run: FloatArray, turn_rad: FloatArray) -> FloatArray:
    """Parameters (m,) at parts (m,) of the lengths of parabolas, both from 0 to 1."""
    half = 2.0 * run - 1.0
    wanted = np.abs(half) * _run(np.ones(len(run)), turn_rad)
    sin, cos = np.sin(turn_rad / 2.0), np.maximum(np.cos(turn_rad / 2.0), 1e-9)
    off = np.ones(len(run))
    for _ in range(NEWTON_STEPS):  # the length is convex: from the end there is no overshooting
        off -= (_run(off, turn_rad) - wanted) / np.sqrt(cos**2 + (off * sin) ** 2)
    parts: FloatArray = 0.5 + 0.5 * np.copysign(np.clip(off, 0.0, 1.0), half)
    return parts


class _Curves:
    """The cubics of corners, (k,), by their four control points."""

    def __init__(self, courses: Courses, corners: Int64Array, away_m: FloatArray):
        leaves_m, reach = courses.length_m[corners] - away_m, (2.0 / 3.0 * away_m)[:, None]
        self._begin, self._end = courses.at(corners, leaves_m), courses.at(corners + 1, away_m)
        self._second = self._begin + reach * courses.headings(corners, leaves_m)
        self._third = self._end - reach * courses.headings(corners + 1, away_m)

    def at(self, rows: Int64Array, part: FloatArray) -> FloatArray:
        """Places (m, 3) of curves (m,) at parts (m,) of their parameters, from 0 to 1."""
        part = part[:, None]
        rest = 1.0 - part
        places: FloatArray = (
            rest**3 * self._begin[rows]
            + 3.0 * rest**2 * part * self._second[rows]
            + 3.0 * rest * part**2 * self._third[rows]
            + part**3 * self._end[rows]
        )
        return places


def _stray_m(courses: Courses, corners: Int64Array, away_m: FloatArray) -> FloatArray:
    """How far curves stay from their corners, or get from both legs: the larger of the two."""
    rows, even = np.repeat(np.arange(len(corners)), SAMPLES), np.linspace(0.0, 1.0, SAMPLES)
    drawn = _Curves(courses, corners, away_m).at(rows, np.tile(even, len(corners)))
    points = drawn.reshape(len(corners), SAMPLES, 3)
    corner = courses.end_m[corners][:, None]
    from_corner = np.linalg.norm(points - corner, axis=2).min(axis=1)
    length_m = courses.length_m[corners]
    before = _from_leg(courses, corners, points, length_m - away_m, length_m)
    after = _from_leg(courses, corners + 1, points, np.zeros(len(corners)), away_m)
    strays: FloatArray = np.maximum(from_corner, np.minimum(before, after).max(axis=1))
    return strays


def _from_leg(
    courses: Courses, rows: Int64Array, points: FloatArray, low_m: FloatArray, high_m: FloatArray
) -> FloatArray:
    """Distances (k, s) of points (k, s, 3) from stretches of legs (k,); no less than they are."""
    run_m = courses.nearest_m(rows, points, low_m, high_m)
    near = courses.at(np.repeat(rows, run_m.shape[1]), run_m.ravel()).reshape(points.shape)
    away: FloatArray = np.linalg.norm(points - near, axis=2)
    for one in np.flatnonzero(courses.is_spline[rows]).tolist():
        stretch = np.linspace(low_m[one], high_m[one], SAMPLES)
        away[one] = from_polyline(points[one], courses.at(np.full(SAMPLES, rows[one]), stretch))
    return away


def from_polyline(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Distance of each point (n, 3) from the nearest line between corners (k, 3) [m]."""
    nearest2 = np.full(len(points), np.inf)
    at_once = max(1, AT_ONCE // max(len(points), 1))
    for first in range(0, len(corners) - 1, at_once):
        ends = corners[first : first + at_once + 1]
        begin, along = ends[:-1], np.diff(ends, axis=0)
        length2 = np.maximum(np.einsum("ki,ki->k", along, along), 1e-30)
        out = points[:, None, :] - begin
        part = np.clip(np.einsum("nki,ki->nk", out, along) / length2, 0.0, 1.0)
        out -= part[:, :, None] * along
        nearest2 = np.minimum(nearest2, np.einsum("nki,nki->nk", out, out).min(axis=1))
    away: FloatArray = np.sqrt(nearest2)
    return away
