"""Periodic errors of gears, found in what a calibration leaves."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.reproduction.uzunovic_2013.kinematics import find_tooth_errors

PER_TURN = np.array([41.0, 90.0, 147.0])


def samples(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Angles over 40 degrees, and errors of 1 mrad with a second harmonic, in noise as large."""
    rng = np.random.default_rng(seed)
    angles_rad = np.deg2rad(rng.uniform(20.0, 60.0, (3000, 3)))
    turned = PER_TURN * angles_rad
    error_rad = 1e-3 * (np.sin(turned) + 0.5 * np.cos(2.0 * turned)) + 2e-4
    return angles_rad, error_rad


def test_their_number_a_turn_and_their_shape_are_found() -> None:
    angles_rad, error_rad = samples()
    noisy_rad = error_rad + np.random.default_rng(1).normal(0.0, 1e-3, error_rad.shape)
    found = find_tooth_errors(angles_rad, noisy_rad)
    np.testing.assert_allclose(found.per_turn, PER_TURN, rtol=0.01)
    other_rad, other_error_rad = samples(seed=2)
    left_rad = found.error_rad(other_rad) - other_error_rad
    # 9 numbers an arm of 3000 samples: a twentieth of the noise.
    assert np.sqrt(np.mean(left_rad**2)) < 1.5e-4
    assert found.numbers == 30


def test_noise_alone_is_hardly_taken_for_teeth() -> None:
    angles_rad, _ = samples()
    noise_rad = np.random.default_rng(3).normal(0.0, 1e-3, angles_rad.shape)
    found = find_tooth_errors(angles_rad, noise_rad)
    assert np.sqrt(np.mean(found.error_rad(angles_rad) ** 2)) == pytest.approx(0.0, abs=1.5e-4)
