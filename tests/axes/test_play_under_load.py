"""Play whose width changes with the load, and friction that builds up, against loops."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.models.effects.axis_play import loose
from deltactl.proof.axis.cases import draw, write_blind
from deltactl.proof.prove.one_case import diagnose_blind


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 60), st.booleans())
def test_the_axis_stays_between_two_ends_that_move(seed: int, count: int, varies: bool) -> None:
    rng = np.random.default_rng(seed)
    driven = np.cumsum(rng.standard_normal(count))
    fresh = rng.random(count) < 0.1
    fresh[0] = True
    starts = rng.uniform(-1.0, 1.0, int(fresh.sum()))
    width = rng.uniform(0.0, 3.0, count) if varies else np.full(count, rng.uniform(0.0, 3.0))
    expected, at, begins = np.empty(count), 0.0, iter(starts)
    for k in range(count):
        low, high = driven[k] - width[k] / 2, driven[k] + width[k] / 2
        at = driven[k] + width[k] / 2 * next(begins) if fresh[k] else min(max(at, low), high)
        expected[k] = at
    none, zero = np.zeros(count), (0.0, 0.0)
    behind = loose(driven, fresh, width, starts, none, zero)
    np.testing.assert_allclose(behind, expected, atol=1e-9)
    if not varies:
        one = loose(driven, fresh, float(width[0]), starts, none, zero)
        np.testing.assert_allclose(one, expected, atol=1e-9)


def wound(driven: np.ndarray, width: float, build_up: float, steps: int) -> np.ndarray:
    """Dahl's friction behind a spring, integrated in small steps; at rest in the middle at first.

    The spring's force, in that of sliding, is what the friction is; it grows with the way of the
    axis, in proportion to the rest of its final size.
    """
    at, force, found = driven[0], 0.0, [driven[0]]
    for before, after in itertools.pairwise(driven):
        step = (after - before) / steps
        for _ in range(steps):
            share = (1.0 - force * np.sign(step)) / (2.0 * build_up)
            moved = step / (1.0 + share)
            at, force = at + moved, force + 2.0 * (step - moved) / width
        found.append(at)
    return np.array(found)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.02, 0.5))
def test_friction_builds_up_over_a_way(seed: int, build_up: float) -> None:
    rng = np.random.default_rng(seed)
    driven = np.cumsum(rng.standard_normal(12))
    fresh = np.arange(len(driven)) == 0
    begun = (float(driven[0]), float(driven[0]))
    none = np.zeros(len(driven))
    axis = loose(driven, fresh, 1.0, np.zeros(1), none, begun, build_up)
    np.testing.assert_allclose(axis, wound(driven, 1.0, build_up, 2000), atol=2e-3)


@pytest.mark.study
def test_friction_of_a_drawn_servo_needs_no_ratio_beside_it(tmp_path: Path) -> None:
    write_blind(draw(77006), tmp_path)
    answer, failure = diagnose_blind(tmp_path)
    assert not failure
    (friction,) = answer["findings"]
    assert friction["effect"] == "joint_friction"
    assert friction["parameters"]["build_up"]["ci95"][0] > 0.0


@pytest.mark.parametrize("build_up", [0.0, 0.08])
def test_an_axis_with_friction_moves_the_same_in_pieces(build_up: float) -> None:
    driven = 0.1 * np.sin(np.linspace(0.0, 9.0, 400)) * np.linspace(1.0, 0.2, 400)
    fresh = np.arange(len(driven)) == 0
    whole = loose(driven, fresh, 0.03, np.zeros(1), np.zeros(400), (0.0, 0.0), build_up)
    parts, before = [], (0.0, 0.0)
    for row in range(400):
        starts = np.zeros(int(fresh[row]))
        one = driven[row : row + 1], fresh[row : row + 1]
        part = loose(*one, 0.03, starts, np.zeros(1), before, build_up)
        before = (float(driven[row]), float(part[0]))
        parts.append(part)
    np.testing.assert_allclose(np.concatenate(parts), whole, atol=1e-6)
