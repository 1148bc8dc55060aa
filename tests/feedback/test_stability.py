"""The loop of the feedback, by its poles, by its margin, and let go."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.firmware_py.feedback.estimator import FAST_S
from deltactl.firmware_py.feedback.settings import FeedbackSettings
from deltactl.firmware_py.feedback.stability import (
    LATEST_S,
    READING_S,
    closed_loop_poles,
    gain_margin,
)

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
