"""Stamps of a log against the readings beside them: which of their steps the motion follows."""

import numpy as np
import pytest

from deltactl.diagnosis.observations.log_errors import sampling_times

PERIOD_S, COUNT = 0.02, 1500


def motion(t_s: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.sin(3.0 * t_s) + 0.4 * np.sin(7.0 * t_s) + 1e-6 * rng.standard_normal(len(t_s))


def error_s(true_s: np.ndarray, times_s: np.ndarray) -> float:
    """Spread of the error; a common shift is no error."""
    return float(np.std(times_s - true_s))


@pytest.mark.parametrize("seed", [1, 2])
def test_a_steady_beat_that_is_stamped_roughly_is_found_again(seed: int) -> None:
    rng = np.random.default_rng(seed)
    true_s = PERIOD_S * 1.00004 * np.arange(COUNT)
    stamps_s = np.round(true_s + rng.uniform(-1e-3, 1e-3, COUNT), 3)
    fresh = np.arange(COUNT) == 0
    found_s = sampling_times(stamps_s, fresh, motion(true_s, rng))
    assert error_s(true_s, found_s) < 0.1 * error_s(true_s, stamps_s)


def test_true_jitter_is_kept() -> None:
    rng = np.random.default_rng(3)
    true_s = PERIOD_S * (np.arange(COUNT) + rng.uniform(-0.2, 0.2, COUNT))
    fresh = np.arange(COUNT) == 0
    assert np.array_equal(sampling_times(true_s, fresh, motion(true_s, rng)), true_s)


def test_of_jitter_and_rough_stamps_together_the_true_part_is_kept() -> None:
    rng = np.random.default_rng(4)
    true_s = PERIOD_S * (np.arange(COUNT) + rng.uniform(-0.05, 0.05, COUNT))
    stamps_s = true_s + PERIOD_S * rng.uniform(-0.05, 0.05, COUNT)
    fresh = np.arange(COUNT) == 0
    found_s = sampling_times(stamps_s, fresh, motion(true_s, rng))
    # Half of either is the best that a straight line can do: the error shrinks by the root of two.
    assert error_s(true_s, found_s) == pytest.approx(error_s(true_s, stamps_s) / 2**0.5, rel=0.05)


def test_lost_rows_and_gaps_are_no_jitter() -> None:
    rng = np.random.default_rng(5)
    true_s = PERIOD_S * np.arange(COUNT)
    kept = rng.random(COUNT) > 0.03
    kept[700:780] = False
    true_s = true_s[kept]
    stamps_s = np.round(true_s + rng.uniform(-1e-3, 1e-3, len(true_s)), 3)
    fresh = np.concatenate([[True], np.diff(true_s) > 10 * PERIOD_S])
    found_s = sampling_times(stamps_s, fresh, motion(true_s, rng))
    assert error_s(true_s, found_s) < 0.15 * error_s(true_s, stamps_s)
