"""The shapes of paths: circle, heart, spiral, points, poses of the arms."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from deltactl.firmware_py.paths.path import Path, Space, curve, intervals, level, line
from deltactl.models.robot import FloatArray


def circle_length_m(radius_m: float, turns: float) -> float:
    """Length of the path [m]."""
    return 2.0 * math.pi * radius_m * abs(turns)


def circle(
    centre_m: tuple[float, float, float], radius_m: float, turns: float, spacing_m: float
) -> Path:
    """`turns` times round from the +x side, counter-clockwise from above if positive.

    Whole turns pass the same points every time and close exactly.
    """
    if float(turns).is_integer():
        per_turn = intervals(circle_length_m(radius_m, 1.0), spacing_m)
        turn = np.arange(int(abs(turns)) * per_turn + 1) % per_turn / per_turn
        turn *= math.copysign(1.0, turns)
    else:
        turn = np.linspace(0.0, turns, intervals(circle_length_m(radius_m, turns), spacing_m) + 1)
    angle_rad = 2.0 * np.pi * turn
    x_m, y_m = radius_m * np.cos(angle_rad), radius_m * np.sin(angle_rad)
    return curve(level(centre_m, x_m, y_m), spacing_m)


HEART_WIDTH = 32.0
_HEART_FINE = 40_001
"""Parameter values along one turn for the arc length: error below 1e-7 of the length."""


def heart_length_m(width_m: float, turns: int) -> float:
    """Length of the path [m]."""
    return float(_heart_arc()[1][-1]) * width_m / HEART_WIDTH * turns


def heart(
    centre_m: tuple[float, float, float], width_m: float, turns: int, spacing_m: float
) -> Path:
    """`turns` times round, from the dent, clockwise seen from above.

    `centre_m` is the middle of its box. The intervals are even in number: the tip is a target.
    """
    t, arc = _heart_arc()
    half = intervals(heart_length_m(width_m, 1) / 2.0, spacing_m)
    at = np.interp(np.linspace(0.0, arc[-1] / 2.0, half + 1), arc, t)
    x, y = _heart_xy(at)
    # The left side mirrors the right one, so that the curve is symmetric and closed exactly.
    x[0] = x[-1] = 0.0
    x_turn, y_turn = np.concatenate([x, -x[-2::-1]]), np.concatenate([y, y[-2::-1]])
    scale_m = width_m / HEART_WIDTH
    once = level(centre_m, scale_m * x_turn, scale_m * (y_turn - _heart_middle()))
    return curve(np.concatenate([once, *([once[1:]] * (turns - 1))]), spacing_m)


def _heart_xy(t: FloatArray) -> tuple[FloatArray, FloatArray]:
    return (
        16.0 * np.sin(t) ** 3,
        13.0 * np.cos(t) - 5.0 * np.cos(2.0 * t) - 2.0 * np.cos(3.0 * t) - np.cos(4.0 * t),
    )


@cache
def _heart_arc() -> tuple[FloatArray, FloatArray]:
    """Parameter and arc length of one turn, in units of the formula."""
    t = np.linspace(0.0, 2.0 * np.pi, _HEART_FINE)
    x, y = _heart_xy(t)
    return t, np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])


@cache
def _heart_middle() -> float:
    """Middle of the heart's box in y: between the tip at -17 and the top of the lobes."""
    # dy/dt = 0 away from the cusps: 32 c^3 + 24 c^2 + 4 c - 19 = 0 with c = cos t.
    roots = np.roots([32.0, 24.0, 4.0, -19.0])
    top = np.arccos(roots[np.abs(roots.imag) < 1e-9].real)
    return (float(_heart_xy(top)[1].max()) - 17.0) / 2.0


def spiral_length_m(inner_radius_m: float, outer_radius_m: float, turns: float) -> float:
    """Length of the path [m]: sqrt(1 + b^2) / b times the growth of the radius."""
    growth = _growth(inner_radius_m, outer_radius_m, turns)
    return math.hypot(1.0, growth) / growth * (outer_radius_m - inner_radius_m)


def spiral(
    centre_m: tuple[float, float, float],
    inner_radius_m: float,
    outer_radius_m: float,
    turns: float,
    spacing_m: float,
) -> Path:
    """From the inner radius on the +x side outwards, counter-clockwise from above.

    The arc length is linear in the radius, so the spacing is equal without any search.
    """
    length = spiral_length_m(inner_radius_m, outer_radius_m, turns)
    radius_m = np.linspace(inner_radius_m, outer_radius_m, intervals(length, spacing_m) + 1)
    growth = _growth(inner_radius_m, outer_radius_m, turns)
    angle_rad = np.log(radius_m / inner_radius_m) / growth
    return curve(
        level(centre_m, radius_m * np.cos(angle_rad), radius_m * np.sin(angle_rad)), spacing_m
    )


def _growth(inner_radius_m: float, outer_radius_m: float, turns: float) -> float:
    """b of r = a exp(b t), per radian."""
    return math.log(outer_radius_m / inner_radius_m) / (2.0 * math.pi * turns)


Point = tuple[float, float, float]


def point_target_count(points_m: Sequence[Point], spacing_m: float) -> int:
    """How many targets the path has."""
    pairs = itertools.pairwise(points_m)
    return 1 + sum(intervals(math.dist(*pair), spacing_m) for pair in pairs)


def points(points_m: Sequence[Point], dwell_s: float, spacing_m: float) -> Path:
    """Lines sampled at `spacing_m`; every given point is a target of its own."""
    corners = np.asarray(points_m, dtype=np.float64)
    lines = [line(start, end, spacing_m)[1:] for start, end in itertools.pairwise(corners)]
    targets = np.concatenate([corners[:1], *lines])
    rest = np.zeros(len(targets), dtype=np.bool_)
    rest[np.cumsum([0, *(len(part) for part in lines)])] = True
    return Path(
        space=Space.CARTESIAN,
        targets=targets,
        dwell_s=np.where(rest, dwell_s, 0.0),
        rest=rest,
        way_back=line(corners[-1], corners[0], spacing_m)[1:-1],
    )


def joints(angles_deg: Sequence[tuple[float, float, float]], dwell_s: float) -> Path:
    """A path through arm angles given in degrees."""
    return through(np.deg2rad(np.asarray(angles_deg, dtype=np.float64)), dwell_s)


def through(angles_rad: FloatArray, dwell_s: float) -> Path:
    """A path through arm angles [rad] of shape (n, 3); back to the first in one move."""
    count = len(angles_rad)
    return Path(
        space=Space.JOINT,
        targets=angles_rad,
        dwell_s=np.full(count, dwell_s),
        rest=np.ones(count, dtype=np.bool_),
        way_back=np.empty((0, 3)),
    )
