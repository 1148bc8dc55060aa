"""The time given to a sample: bounded by the polls, and much better than that after a while."""

from __future__ import annotations

import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.drivers.ranging.sample_reader import DRIFT, SAMPLES_PER_ANCHOR, SampleTimes
from deltactl.foundation.clock import ns

RANGE_NS, COLLECTION_NS = ns(0.0126), ns(0.008)


def _errors_s(
    period_s: float, slowness: float, poll_s: float, jitter_s: float, duration_s: float, seed: int
) -> tuple[np.ndarray, SampleTimes]:
    """Errors of the estimated times of a sensor off by `slowness`, polled with jitter."""
    chance = random.Random(seed)
    times = SampleTimes(ns(period_s), RANGE_NS, COLLECTION_NS)
    times.started(0)
    true_period_ns, first_ns = period_s * slowness * 1e9, RANGE_NS * slowness
    last, absent_ns, poll_ns, errors = 0, 0, 0.0, []
    while poll_ns < duration_s * 1e9:
        poll_ns += (poll_s + chance.uniform(0.0, jitter_s)) * 1e9
        newest = int((poll_ns - first_ns) // true_period_ns)
        if newest > last:
            samples = (newest - last) % 128 or 128
            middle_ns = times.middle_ns(samples, absent_ns, int(poll_ns))
            true_ns = first_ns + newest * true_period_ns - COLLECTION_NS / 2
            errors.append((middle_ns - true_ns) * 1e-9)
            last = newest
        absent_ns = int(poll_ns)
    return np.array(errors), times


def test_with_a_true_clock_the_times_are_exact() -> None:
    errors_s, times = _errors_s(0.02, 1.0, 0.02, 0.0, 10.0, 1)
    assert np.abs(errors_s).max() < 1e-6
    assert times.measured_hz == pytest.approx(50.0, rel=0.01)


@settings(max_examples=30, deadline=None)
@given(
    slowness=st.floats(0.97, 1.03),
    poll_s=st.floats(0.005, 0.05),
    jitter_s=st.floats(0.0, 0.01),
    seed=st.integers(0, 10**6),
)
def test_no_error_exceeds_the_distance_of_two_polls(
    slowness: float, poll_s: float, jitter_s: float, seed: int
) -> None:
    errors_s, _ = _errors_s(0.02, slowness, poll_s, jitter_s, 6.0, seed)
    assert np.abs(errors_s).max() <= poll_s + jitter_s + 1e-6


@pytest.mark.parametrize("slowness", [0.99, 0.998, 1.002, 1.01])
@pytest.mark.parametrize("poll_s", [0.01, 0.0195])
def test_a_slow_or_fast_oscillator_is_learnt(slowness: float, poll_s: float) -> None:
    errors_s, _ = _errors_s(0.02, slowness, poll_s, 0.001, 60.0, 3)
    late = errors_s[len(errors_s) // 2 :]
    assert np.sqrt(np.mean(late**2)) < 0.001


def test_a_long_silence_is_bridged_by_the_time() -> None:
    times = SampleTimes(ns(0.02), RANGE_NS, COLLECTION_NS)
    times.started(0)
    newest = 128 * 3 + 7  # the stream count shows the 7 only
    ready_ns = RANGE_NS + newest * ns(0.02)
    middle_ns = times.middle_ns(7, 0, ready_ns + ns(0.001))
    assert middle_ns == ready_ns - COLLECTION_NS // 2


def test_a_count_that_does_not_fit_the_time_is_implausible() -> None:
    times = SampleTimes(ns(0.02), RANGE_NS, COLLECTION_NS)
    times.started(0)
    now_ns = RANGE_NS + ns(0.02 * 10.5)
    assert times.plausible(10, now_ns)
    assert times.plausible(9, now_ns)
    assert not times.plausible(74, now_ns)


def test_half_the_rate_is_seen() -> None:
    _, times = _errors_s(0.02, 2.0, 0.01, 0.0, 12.0, 1)
    assert times.measured_hz == pytest.approx(25.0, rel=0.05)


def test_the_period_may_drift_either_way_from_one_anchor_to_the_next() -> None:
    """By a thousandth in a minute, as a sensor warms up."""
    times = SampleTimes(ns(0.02), RANGE_NS, COLLECTION_NS)
    times.started(0)
    bounds = []
    for number in range(1, SAMPLES_PER_ANCHOR + 1):
        ready_ns = RANGE_NS + number * ns(0.02)
        times.middle_ns(1, ready_ns - ns(0.01), ready_ns + ns(0.001))
        bounds.append((times._shortest_ns, times._longest_ns))
    (shorter, longer), (shortest, longest) = bounds[-2:]
    assert shortest - shorter == pytest.approx(-DRIFT * ns(0.02), abs=100)
    assert longest - longer == pytest.approx(DRIFT * ns(0.02), abs=100)


def test_a_sample_is_no_sooner_than_one_shortest_period_after_the_last() -> None:
    """Also where the polls between did not happen, and say nothing."""
    times = SampleTimes(ns(0.02), RANGE_NS, COLLECTION_NS)
    times.started(0)
    first_ns = RANGE_NS + ns(0.02)
    times.middle_ns(1, first_ns + ns(0.0015), first_ns + ns(0.0019))  # the clock is slow by 7 %
    middle_ns = times.middle_ns(1, 0, first_ns + ns(0.03))
    assert middle_ns + COLLECTION_NS // 2 >= first_ns + ns(0.0015) + 0.9 * ns(0.02)
    assert times._earliest_ns == pytest.approx(first_ns + ns(0.0015) + 0.9 * ns(0.02))


@pytest.mark.parametrize("slowness", [0.96, 1.04])
def test_a_period_that_contradicts_what_was_learnt_is_learnt_anew(slowness: float) -> None:
    """After a minute at its nominal pace it keeps another one."""
    times = SampleTimes(ns(0.02), RANGE_NS, COLLECTION_NS)
    times.started(0)
    ready_ns, errors_s = float(RANGE_NS), []
    for number in range(4000):
        ready_ns += ns(0.02) * (slowness if number > 2500 else 1.0)
        late_ns = 1 + number * 7919 % ns(0.002)
        seen_ns = round(ready_ns + late_ns)
        middle_ns = times.middle_ns(1, seen_ns - ns(0.003), seen_ns)
        errors_s.append((middle_ns + COLLECTION_NS / 2 - ready_ns) * 1e-9)
    assert np.abs(errors_s[:2500]).max() < 1e-6
    assert np.abs(errors_s[2600:]).max() < 0.003  # the distance of two polls
    assert times._period_ns == pytest.approx(slowness * ns(0.02), rel=1e-3)
