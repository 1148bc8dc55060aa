"""The estimator of slow errors against what least squares must give, and against liars."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.firmware_py.feedback.estimator import Estimate, SlowErrors
from deltactl.firmware_py.feedback.residuals import Residuals
from deltactl.models.robot import FloatArray

LOOK_NS = 100_000_000
SLOPE = np.array([[0.24, -0.1, -0.12], [0.01, 0.21, -0.2], [-0.2, -0.19, -0.22]])
NOISE_M = 0.002


class Bench:
    """Rows as three sensors at 50 Hz would give them."""

    def __init__(self, seed: int = 1):
        self.errors = SlowErrors(NOISE_M)
        self.rng = np.random.default_rng(seed)
        self.now_ns = 0

    def run(
        self,
        seconds: float,
        error_rad: FloatArray,
        bias_m: FloatArray | None = None,
        late_s: float = 0.0,
        outliers: float = 0.0,
    ) -> Estimate:
        found = None
        for _ in range(round(seconds * 10)):
            self.now_ns += LOOK_NS
            axis = np.tile([0, 1, 2], 5)
            wobble = 1.0 + 0.2 * np.sin(1e-9 * self.now_ns + np.arange(3.0))
            slope = SLOPE[axis] * wobble
            rate = 0.06 * np.sin(0.5e-9 * self.now_ns + axis)
            excess = slope @ error_rad - late_s * rate + self.rng.normal(0.0, NOISE_M, 15)
            excess += 0.0 if bias_m is None else bias_m[axis]
            excess += (self.rng.random(15) < outliers) * 0.08
            times = self.now_ns - np.arange(15)[::-1] * 20_000_000 // 3
            found = self.errors.look(Residuals(times, axis, excess, slope, rate), self.now_ns)
        assert found is not None
        return found


@pytest.mark.study
def test_the_error_is_found_and_its_covariance_is_true() -> None:
    truth = np.array([0.004, -0.002, 0.001])
    runs = [Bench(seed).run(6.0, truth) for seed in range(30)]
    off = np.array([(run.error_rad - truth) / run.sigma_rad for run in runs])
    assert 0.6 < float(np.sqrt(np.mean(off**2))) < 1.5
    assert np.all(runs[0].sigma_rad < 1e-3)


def test_more_readings_make_it_as_much_surer_as_they_must() -> None:
    bench = Bench()
    early = bench.run(5.0, np.zeros(3)).sigma_rad
    late = bench.run(15.0, np.zeros(3)).sigma_rad
    np.testing.assert_allclose(late, early / 2.0, rtol=0.25)


def test_a_jump_is_followed_within_two_seconds_and_outliers_are_not() -> None:
    bench = Bench()
    quiet = bench.run(20.0, np.zeros(3), outliers=0.02)
    assert np.abs(quiet.error_rad).max() < 1e-3
    jump = np.array([0.0, -0.039, 0.0])
    found = bench.run(2.5, jump)
    np.testing.assert_allclose(found.error_rad, jump, atol=2e-3)
    assert found.suspect == ""


@pytest.mark.parametrize("late_s", [0.05, 0.2])
def test_late_readings_are_no_error_of_the_arms(late_s: float) -> None:
    found = Bench().run(30.0, np.zeros(3), late_s=late_s)
    assert np.abs(found.error_rad).max() < 1.5e-3
    assert found.late_s == pytest.approx(late_s, abs=0.01)


def test_one_sensor_that_lies_is_named_and_nothing_is_learned_from_it() -> None:
    bench = Bench()
    bench.run(10.0, np.zeros(3))
    found = bench.run(3.0, np.zeros(3), bias_m=np.array([0.0, 0.02, 0.0]))
    assert found.suspect == "y"
    assert np.abs(found.error_rad).max() < 3e-3
