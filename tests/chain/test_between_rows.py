"""A motion between rows far apart, against the same motion made moment by moment."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.models.robot import FloatArray
from deltactl.models.signals import late, slopes_of

FINE_S = 1e-3


def moved(t_s: FloatArray) -> FloatArray:
    """Two waves, no row of which is at rest."""
    return np.asarray(0.3 * np.sin(1.1 * t_s) + 0.1 * np.sin(2.7 * t_s + 1.0))


def behind(t_s: FloatArray, dead_s: float, time_s: float) -> FloatArray:
    """The same behind a dead time and a lag, by small steps."""
    fine_s = np.arange(t_s[0] - 20.0, t_s[-1] + FINE_S, FINE_S)
    asked = moved(fine_s + 0.5 * FINE_S - dead_s)
    part, at, seen = 1.0 - np.exp(-FINE_S / time_s), 0.0, np.empty_like(fine_s)
    for k, aim in enumerate(asked):
        seen[k] = at
        at += (aim - at) * part
    return np.asarray(np.interp(t_s, fine_s, seen))


def in_one_stretch(x: FloatArray, t_s: FloatArray, dead_s: float, time_s: float) -> FloatArray:
    step_s = np.diff(t_s, prepend=t_s[0])
    slopes = slopes_of(x, t_s, step_s)
    return late(x, slopes, t_s, np.full(len(t_s), t_s[0]), dead_s, time_s)


@pytest.mark.parametrize(("dead_s", "time_s"), [(0.13, 0.05), (0.05, 0.3), (0.4, 0.02)])
def test_rows_far_apart_lose_little_of_a_delay(dead_s: float, time_s: float) -> None:
    t_s = np.arange(0.0, 40.0, 0.2)
    found = in_one_stretch(moved(t_s), t_s, dead_s, time_s)
    later = t_s > 10.0 * (dead_s + time_s)
    error = (found - behind(t_s, dead_s, time_s))[later]
    straight = np.interp(t_s - dead_s, t_s, moved(t_s)) - moved(t_s - dead_s)
    assert np.std(error) < 2e-3
    assert np.std(error) < 0.3 * np.std(straight[later]) or np.std(error) < 1e-3


@given(
    dead_s=st.floats(0.0, 1.0),
    time_s=st.sampled_from([0.0, 1e-4, 0.01, 0.1, 1.0]),
    jump=st.integers(5, 30),
)
def test_it_goes_nowhere_beyond_a_step(dead_s: float, time_s: float, jump: int) -> None:
    """A command that jumps between two rows, after rest and before it: no ringing."""
    t_s = np.arange(40) * 0.1
    x = np.where(np.arange(40) < jump, 0.0, 1.0)
    found = in_one_stretch(x, t_s, dead_s, time_s)
    assert found.min() >= -1e-12
    assert found.max() <= 1.0 + 1e-12
    assert (np.diff(found) >= -1e-12).all()


@given(slope=st.floats(-2.0, 2.0), dead_s=st.floats(0.0, 0.5), time_s=st.floats(1e-6, 0.5))
def test_of_a_steady_motion_both_delays_are_their_sum(
    slope: float, dead_s: float, time_s: float
) -> None:
    t_s = np.arange(0.0, 30.0, 0.25)
    found = in_one_stretch(slope * t_s, t_s, dead_s, time_s)
    assert found[-1] == pytest.approx(slope * (t_s[-1] - dead_s - time_s), abs=1e-9)


def test_each_stretch_begins_at_rest() -> None:
    t_s = np.concatenate([np.arange(20) * 0.1, 5.0 + np.arange(20) * 0.1])
    x = np.concatenate([np.linspace(0.0, 1.0, 20), np.linspace(3.0, 4.0, 20)])
    step_s = np.diff(t_s, prepend=t_s[0])
    step_s[20] = 0.0
    start_s = np.where(np.arange(40) < 20, 0.0, 5.0)
    found = late(x, slopes_of(x, t_s, step_s), t_s, start_s, 0.15, 0.1)
    assert found[0] == x[0]
    assert found[20] == x[20]
    assert found[21] >= 3.0


@given(speed=st.floats(0.01, 5.0), leap=st.floats(-80.0, 80.0), back=st.booleans())
def test_a_leap_is_not_the_slope_of_what_comes_after(speed: float, leap: float, back: bool) -> None:
    """A motion that rests, leaps between two rows and goes on steadily, or the other way round."""
    t_s = np.arange(20) * 0.1
    x = np.where(t_s < 1.0, 0.0, leap + speed * (t_s - 1.0))
    x = x[::-1].copy() if back else x
    slope = slopes_of(x, t_s, np.diff(t_s, prepend=t_s[0]))
    assert np.abs(slope).max() < 1.6 * speed or abs(leap) < 0.1 * speed
