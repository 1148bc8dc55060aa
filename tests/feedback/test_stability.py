"""The loop of the feedback, by its poles, by its margin, and let go.

A reading that is stamped t but was taken at t - d is compared with the edges sent up to t. What was
corrected within d is then missing in it, and looks like an error that came: the estimate is fed
back by F(s) (1 - exp(-s d)), with F the estimator. Of its two parts the fast one, a mean over
`FAST_S`, is the worst: the slow one begins as that mean and only becomes slower. So the loop judged
here is a mean over N readings with a delay of k. See docs/decisions/feedback-stability.md.
"""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.firmware_py.feedback.estimator import FAST_S
from deltactl.firmware_py.feedback.settings import FeedbackSettings
from deltactl.models.robot import FloatArray

LATEST_S = 0.2
"""The loop is shown to be stable for readings up to this late."""
READING_S = 0.02
"""At 50 Hz; from faster readings the loop is the same within a reading."""


def closed_loop_poles(
    latency_s: float, window_s: float = FAST_S, period_s: float = READING_S
) -> FloatArray:
    """Absolute values of the poles of e[n] = mean over the window of (e[n-i] - e[n-i-k]).

    Largest first; the loop is stable where all are below 1.
    """
    mean, delay = _in_readings(latency_s, window_s, period_s)
    if not delay:
        return np.zeros(1)
    # z^(N+k) - 1/N (sum of z^(N+k-i) - sum of z^(N-i)), i = 1 to N
    polynomial = np.zeros(mean + delay + 1)
    polynomial[0] = 1.0
    polynomial[1 : mean + 1] -= 1.0 / mean
    polynomial[1 + delay : mean + delay + 1] += 1.0 / mean
    sizes: FloatArray = np.sort(np.abs(np.roots(polynomial)))[::-1]
    return sizes


def gain_margin(latency_s: float, window_s: float = FAST_S, period_s: float = READING_S) -> float:
    """By how much the loop's gain could be larger at any frequency; infinite without a delay.

    1 / max |F (1 - exp(-s d))|: above 1 the loop is stable whatever its phase is (small gain), and
    so it stays with steps that are whole, held back or bounded, none of which makes a correction
    larger than was asked for.
    """
    mean, delay = _in_readings(latency_s, window_s, period_s)
    if not delay:
        return float("inf")
    turn = np.linspace(1e-4, np.pi, 20_001)
    averaged = np.sin(0.5 * mean * turn) / (mean * np.sin(0.5 * turn))
    fed_back = 2.0 * np.abs(np.sin(0.5 * delay * turn))
    return float(1.0 / np.max(np.abs(averaged) * fed_back))


def _in_readings(latency_s: float, window_s: float, period_s: float) -> tuple[int, int]:
    return max(1, round(window_s / period_s)), round(latency_s / period_s)


LATENCIES = np.arange(0.0, LATEST_S + READING_S / 2.0, READING_S)


@pytest.mark.parametrize("latency_s", LATENCIES)
def test_every_pole_is_within_the_circle_and_the_margin_is_above_two(latency_s: float) -> None:
    assert closed_loop_poles(latency_s).max() < 1.0
    assert gain_margin(latency_s) > 2.0


def test_the_margin_is_what_the_closed_form_says() -> None:
    # |F| <= 1 / (w W / 2) and |1 - exp(-jwd)| <= w d: their product is 2 d / W at most.
    for latency_s in LATENCIES[1:]:
        assert gain_margin(latency_s) >= 0.99 * FAST_S / (2.0 * latency_s)


def test_a_window_shorter_than_the_delay_has_no_margin_left() -> None:
    assert gain_margin(0.4, window_s=0.1) < 1.0


@pytest.mark.parametrize("latency_s", [0.06, 0.2])
def test_what_is_let_go_dies_away_as_the_largest_pole_says(latency_s: float) -> None:
    mean, delay = round(FAST_S / READING_S), round(latency_s / READING_S)
    estimate = [0.0] * (mean + delay) + [1.0]
    for _ in range(600):
        now = np.mean([estimate[-i] - estimate[-i - delay] for i in range(1, mean + 1)])
        estimate.append(float(now))
    largest = closed_loop_poles(latency_s).max()
    early, late = (np.abs(estimate[a:b]).max() for a, b in ((150, 250), (550, 650)))
    assert late < 1e-3
    assert late <= 3.0 * early * largest**400


def test_what_is_corrected_at_least_is_less_than_what_is_at_most() -> None:
    with pytest.raises(ValueError, match="least_m must be smaller"):
        FeedbackSettings(least_m=0.01, most_m=0.005)
