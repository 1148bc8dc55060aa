"""Samples that a logger takes unevenly: velocity and acceleration are those of the motion."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.diagnosis.observations.inverse_dynamics import motion_of


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000), jitter=st.sampled_from([0.0, 0.1, 0.25]))
def test_uneven_samples_do_not_bend_time(seed: int, jitter: float) -> None:
    rng = np.random.default_rng(seed)
    t_s = 0.01 * np.cumsum(1.0 + jitter * rng.choice([-1.0, 1.0], 3000))
    turns = 2.0 * np.pi * np.array([0.11, 0.37])
    phases = turns * t_s[:, None] + rng.uniform(0.0, 6.0, 2)
    position = np.sin(phases).sum(axis=1) + 1e-5 * rng.standard_normal(len(t_s))
    velocity = (turns * np.cos(phases)).sum(axis=1)
    acceleration = -(turns**2 * np.sin(phases)).sum(axis=1)
    motion = motion_of(t_s, t_s == t_s[0], position, None)
    inside = motion.settled
    assert inside.mean() > 0.8
    off = motion.velocity - velocity, motion.acceleration - acceleration
    assert np.std(off[0][inside]) < 0.01 * np.std(velocity)
    assert np.std(off[1][inside]) < 0.03 * np.std(acceleration)
    measured = motion_of(t_s, t_s == t_s[0], position, velocity)
    assert np.std((measured.velocity - motion.velocity)[inside]) < 0.01 * np.std(velocity)
