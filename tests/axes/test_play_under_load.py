"""Play whose width changes with the load, against a loop over the samples."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.models.effects.axis_play import loose


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
    none = np.zeros(count)
    np.testing.assert_allclose(loose(driven, fresh, width, starts, none, 0.0), expected, atol=1e-9)
    if not varies:
        one = loose(driven, fresh, float(width[0]), starts, none, 0.0)
        np.testing.assert_allclose(one, expected, atol=1e-9)
