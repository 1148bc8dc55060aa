"""A corner between two legs, cut: a curve that leaves one and meets the other in its direction.

The curve is the cubic with both headings as its ends' tangents; between straight legs that is
the parabola whose middle is nearest to the corner. How early it leaves follows from how far it
may stray: in closed form between straight legs, by halving elsewhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from deltactl.firmware_py.paths.courses import Course, Straight
from deltactl.firmware_py.paths.path import intervals
from deltactl.models.robot import FloatArray

STRAIGHT_RAD = math.radians(0.5)
"""Legs that meet at less than this go on into each other without a stop."""
HALVINGS = 24
SAMPLES = 129
KEPT = 0.999
"""Share of what may be cut that is used: between so many samples a curve strays a little further,
by less than a ten-thousandth in the worst of those that were tried."""
AT_ONCE = 200_000
"""Pairs of a point and a line looked at together: a few MB."""
MEASURED_AT = 201


@dataclass(frozen=True, slots=True)
class Cut:
    """Where a leg is left, where the next one is met (lengths run [m]), and the curve's points."""

    leaves_m: float
    meets_m: float
    points: FloatArray


def turn_rad(own: Course, following: Course) -> float:
    """By how much the way turns from one leg to the next; half a turn where one has no length."""
    one, other = own.heading(own.length_m), following.heading(0.0)
    if not one.any() or not other.any():
        return math.pi
    return math.acos(max(-1.0, min(1.0, float(one @ other))))


def cut(
    own: Course, left_m: float, following: Course, corner_m: float, spacing_m: float
) -> Cut | None:
    """The corner between two legs, of the first of which `left_m` has been run already.

    The curve passes within `corner_m` of the corner, and is nowhere further from the legs.
    None where there is no corner, or no room for a curve.
    """
    turn = turn_rad(own, following)
    if turn <= STRAIGHT_RAD or corner_m <= 0.0:
        return None
    room = min(own.length_m - left_m, 0.5 * following.length_m)
    if isinstance(own, Straight) and isinstance(following, Straight):
        away = min(2.0 * corner_m / math.sin(turn / 2.0), room)
        pieces = intervals(_parabola_m(away, turn), spacing_m)
        if away > 0.0 and pieces <= 2:
            points = _short_parabola(own, following, away, pieces)
            return Cut(own.length_m - away, away, points)
    else:
        away = _widest(own, following, corner_m, room)
    if away <= 0.0:
        return None
    return Cut(own.length_m - away, away, _evenly(own, following, away, spacing_m))


def _parabola_m(away: float, turn: float) -> float:
    """How long the parabola is that begins and ends so far from a corner of straight legs [m]."""
    half_sin, half_cos = math.sin(turn / 2.0), math.cos(turn / 2.0)
    if half_cos < 1e-9:
        return away
    return away * (1.0 + half_cos**2 * math.asinh(half_sin / half_cos) / half_sin)


def _short_parabola(own: Straight, following: Straight, away: float, pieces: int) -> FloatArray:
    """Its ends, and where there are two pieces its middle, which needs no measuring."""
    corner = own.end
    begin, end = corner - away * own.heading(0.0), corner + away * following.heading(0.0)
    if pieces == 1:
        return np.array([begin, end])
    return np.array([begin, 0.25 * (begin + end) + 0.5 * corner, end])


def _evenly(own: Course, following: Course, away: float, spacing_m: float) -> FloatArray:
    """Points of the curve as far apart as those of the legs."""
    part = np.linspace(0.0, 1.0, MEASURED_AT)
    hops = np.linalg.norm(np.diff(_curve(own, following, away, part), axis=0), axis=1)
    run_m = np.concatenate([[0.0], np.cumsum(hops)])
    wanted_m = np.linspace(0.0, run_m[-1], intervals(float(run_m[-1]), spacing_m) + 1)
    return _curve(own, following, away, np.interp(wanted_m, run_m, part))


def _curve(own: Course, following: Course, away: float, part: FloatArray) -> FloatArray:
    """Places (n, 3) at parts of the curve's parameter, (n,), from 0 to 1."""
    leaves_m = own.length_m - away
    begin, end = own.at(np.array([leaves_m]))[0], following.at(np.array([away]))[0]
    reach = 2.0 / 3.0 * away
    second = begin + reach * own.heading(leaves_m)
    third = end - reach * following.heading(away)
    part = part[:, None]
    rest = 1.0 - part
    points: FloatArray = (
        rest**3 * begin
        + 3.0 * rest**2 * part * second
        + 3.0 * rest * part**2 * third
        + part**3 * end
    )
    return points


def _widest(own: Course, following: Course, corner_m: float, room: float) -> float:
    """The longest way before the corner at which a curve still keeps to the legs."""
    most_m = KEPT * corner_m
    if _strays_m(own, following, room) <= most_m:
        return room
    low, high = 0.0, room
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        if _strays_m(own, following, middle) <= most_m:
            low = middle
        else:
            high = middle
    return low


def _strays_m(own: Course, following: Course, away: float) -> float:
    """How far the curve stays from the corner, or gets from both legs: the larger of the two."""
    points = _curve(own, following, away, np.linspace(0.0, 1.0, SAMPLES))
    run_m = np.linspace(0.0, away, SAMPLES)
    legs = np.concatenate([own.at(own.length_m - run_m[::-1]), following.at(run_m)[1:]])
    corner = legs[SAMPLES - 1]
    from_corner = float(np.linalg.norm(points - corner, axis=1).min())
    return max(from_corner, float(from_polyline(points, legs).max()))


def from_polyline(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Distance of each point (n, 3) from the nearest line between corners (k, 3) [m]."""
    nearest = np.full(len(points), np.inf)
    at_once = max(1, AT_ONCE // max(len(points), 1))
    for first in range(0, len(corners) - 1, at_once):
        ends = corners[first : first + at_once + 1]
        begin, along = ends[:-1], np.diff(ends, axis=0)
        length2 = np.maximum(np.einsum("ki,ki->k", along, along), 1e-30)
        out = points[:, None, :] - begin
        part = np.clip(np.einsum("nki,ki->nk", out, along) / length2, 0.0, 1.0)
        away = np.linalg.norm(out - part[:, :, None] * along, axis=2)
        nearest = np.minimum(nearest, away.min(axis=1))
    return nearest
