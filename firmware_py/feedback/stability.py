"""Why feedback cannot ring: poles and margin of its loop when readings are late and nobody knows.

A reading that is stamped t but was taken at t - d is compared with the edges sent up to t. What was
corrected within d is then missing in it, and looks like an error that came: the estimate is fed
back by F(s) (1 - exp(-s d)), with F the estimator. Of its two parts the fast one, a mean over
`FAST_S`, is the worst: the slow one begins as that mean and only becomes slower. So the loop judged
here is a mean over N readings with a delay of k. See docs/decisions/feedback-stability.md.
"""

from __future__ import annotations

import numpy as np

from deltactl.firmware_py.feedback.estimator import FAST_S
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
