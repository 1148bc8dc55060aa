"""Shapes: exact lengths, equal spacing, exact closing, and the formulas they are named for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.paths.path import Path, Space
from deltactl.firmware_py.paths.shapes import (
    circle,
    circle_length_m,
    heart,
    point_target_count,
    points,
    spiral,
    spiral_length_m,
)

lengths = st.floats(0.01, 0.3)
spacings = st.floats(0.0005, 0.01)
CENTRE = (0.02, -0.01, -0.45)


def hops_m(path: Path) -> np.ndarray:
    return np.linalg.norm(np.diff(path.targets, axis=0), axis=1)


@settings(max_examples=25, deadline=None)
@given(radius_m=lengths, turns=st.floats(0.1, 4.0), spacing_m=spacings, back=st.booleans())
def test_circle_keeps_its_radius_and_spacing(radius_m, turns, spacing_m, back):
    turns = -turns if back else turns
    path = circle(CENTRE, radius_m, turns, spacing_m)
    away = path.targets - np.array(CENTRE)
    assert np.hypot(away[:, 0], away[:, 1]) == pytest.approx(radius_m)
    assert (path.targets[:, 2] == CENTRE[2]).all()
    hops = hops_m(path)
    assert hops.max() <= spacing_m * (1 + 1e-9)
    assert np.ptp(hops) < 1e-12
    # A chord is shorter than its arc by (spacing / radius)^2 / 24, and no more.
    exact = circle_length_m(radius_m, turns)
    assert exact * (1 - (spacing_m / radius_m) ** 2 / 20) <= hops.sum() <= exact * (1 + 1e-12)
    turned = away[0, 0] * away[1, 1] - away[0, 1] * away[1, 0]
    assert np.sign(turned) == np.sign(turns)


@pytest.mark.parametrize("turns", [1, -1, 3, -2])
def test_whole_turns_close_exactly_and_repeat_themselves(turns):
    path = circle(CENTRE, 0.1, turns, 0.0007)
    per_turn = (len(path) - 1) // abs(turns)
    assert path.is_closed
    for turn in range(abs(turns)):
        start = turn * per_turn
        assert (path.targets[start : start + per_turn] == path.targets[:per_turn]).all()


def test_part_of_a_turn_is_open_and_goes_back_straight():
    path = circle(CENTRE, 0.1, 0.5, 0.001)
    assert not path.is_closed
    way = np.concatenate([path.targets[-1:], path.way_back, path.targets[:1]])
    assert np.linalg.norm(np.diff(way, axis=0), axis=1) == pytest.approx(0.001, rel=1e-6)
    assert way[:, 1] == pytest.approx(CENTRE[1])


@settings(max_examples=20, deadline=None)
@given(width_m=lengths, spacing_m=spacings, turns=st.integers(1, 3))
def test_heart_is_as_wide_as_asked_centred_symmetric_and_closed(width_m, spacing_m, turns):
    path = heart(CENTRE, width_m, turns, spacing_m)
    assert path.is_closed
    per_turn = (len(path) - 1) // turns
    once = path.targets[: per_turn + 1] - np.array(CENTRE)
    assert np.abs(once[:, 0] + once[::-1, 0]).max() < 1e-15
    assert (once[:, 1] == once[::-1, 1]).all()
    assert hops_m(path).max() <= spacing_m * (1 + 1e-9)
    # The sampling can miss the widest place by half a spacing along the curve.
    assert width_m - spacing_m <= np.ptp(once[:, 0]) <= width_m * (1 + 1e-12)
    tip = per_turn // 2
    assert once[tip, 0] == 0.0
    assert once[tip, 1] == once[:, 1].min()


def heart_y(cos: np.ndarray) -> np.ndarray:
    cos2, cos3, cos4 = 2 * cos**2 - 1, 4 * cos**3 - 3 * cos, 8 * cos**4 - 8 * cos**2 + 1
    return 13 * cos - 5 * cos2 - 2 * cos3 - cos4


def test_heart_satisfies_its_formula():
    """x = 16 sin^3 t gives sin t, and cos t up to its sign; y must be that of one of the signs."""
    path = heart((0, 0, -0.4), 0.32, 1, 0.002)
    y = heart_y(np.cos(np.linspace(0, 2 * np.pi, 100_001)))
    middle = (y.max() + y.min()) / 2
    cos = np.sqrt(1 - np.cbrt(path.targets[:, 0] / 0.16) ** 2)
    error = [np.abs(path.targets[:, 1] / 0.01 + middle - heart_y(side)) for side in (cos, -cos)]
    assert np.min(error, axis=0).max() < 1e-6


def test_heart_spacing_is_even_off_the_cusps():
    hops = hops_m(heart(CENTRE, 0.2, 1, 0.0005))
    assert hops.max() / hops.min() < 1.001


@settings(max_examples=25, deadline=None)
@given(
    inner_m=st.floats(0.005, 0.05),
    growth=st.floats(1.2, 10.0),
    turns=st.floats(0.3, 4.0),
    spacing_m=spacings,
)
def test_spiral_is_logarithmic_with_even_spacing(inner_m, growth, turns, spacing_m):
    outer_m = inner_m * growth
    path = spiral(CENTRE, inner_m, outer_m, turns, spacing_m)
    away = path.targets - np.array(CENTRE)
    radius = np.hypot(away[:, 0], away[:, 1])
    assert radius[[0, -1]] == pytest.approx([inner_m, outer_m])
    angle = np.log(radius / inner_m) / (math.log(growth) / (2 * math.pi * turns))
    assert away[:, 0] == pytest.approx(radius * np.cos(angle), abs=1e-9)
    assert away[:, 1] == pytest.approx(radius * np.sin(angle), abs=1e-9)
    hops = hops_m(path)
    assert hops.max() <= spacing_m * (1 + 1e-9)
    # Chords of equal arcs: shorter only by their curvature, at most 1 / (inner radius).
    arc = spiral_length_m(inner_m, outer_m, turns) / len(hops)
    assert hops.min() >= arc * (1 - (arc / inner_m) ** 2 / 8)


@settings(max_examples=25, deadline=None)
@given(
    corners=st.lists(
        st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-0.6, -0.3)),
        min_size=1,
        max_size=6,
    ),
    spacing_m=st.floats(0.002, 0.05),
    dwell_s=st.floats(0, 5),
)
def test_points_rest_exactly_at_the_given_points(corners, spacing_m, dwell_s):
    path = points(corners, dwell_s, spacing_m)
    assert len(path) == point_target_count(corners, spacing_m)
    assert (path.targets[path.rest] == np.array(corners)).all()
    assert (path.dwell_s[path.rest] == dwell_s).all()
    assert (path.dwell_s[~path.rest] == 0.0).all()
    if len(path) > 1:
        assert hops_m(path).max() <= spacing_m * (1 + 1e-9)
    assert path.space is Space.CARTESIAN
