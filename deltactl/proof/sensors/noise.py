"""The noise of ranging sensors: correlated, with outliers and readings flagged invalid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import lfilter

from deltactl.proof.robot.as_built import FloatArray

IntArray = np.ndarray[Any, np.dtype[np.int64]]
STATUSES = (1, 2, 7)
"""Sigma too large, signal too weak, wrapped target (VL53L1X, ST's numbering)."""


@dataclass(frozen=True)
class Noise:
    """sigma_m: standard deviation of good readings; rho: correlation from sample to sample."""

    sigma_m: float = 0.002
    rho: float = 0.0
    outliers: float = 0.003
    """Share of readings that are wrong by centimetres though their status is 0."""
    dropouts: float = 0.01
    """Share of readings flagged invalid; their distance is anything."""
    dropout_samples: float = 1.0
    """How many readings in a row are invalid, on average (geometric)."""


SILENT = Noise(0.0, 0.0, 0.0, 0.0)


def wander(noise: Noise, samples: int, rng: np.random.Generator) -> FloatArray:
    """First-order correlated noise, stationary from the first sample on, (samples, 3) [m]."""
    white = rng.standard_normal((samples, 3))
    fresh = np.sqrt(1.0 - noise.rho**2)
    start = noise.rho * rng.standard_normal((1, 3))
    walk: FloatArray = lfilter([fresh], [1.0, -noise.rho], white, axis=0, zi=start)[0]
    return noise.sigma_m * walk


def outliers(noise: Noise, reading: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Some readings jump by 2 to 15 cm."""
    hit = rng.random(reading.shape) < noise.outliers
    jump = rng.choice([-1.0, 1.0], reading.shape) * rng.uniform(0.02, 0.15, reading.shape)
    jumping: FloatArray = reading + hit * jump
    return jumping


def dropouts(
    noise: Noise, reading: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, IntArray]:
    """Some readings are invalid: their status says so and their distance means nothing."""
    begins = rng.random(reading.shape) < noise.dropouts / noise.dropout_samples
    lasts = rng.geometric(1.0 / noise.dropout_samples, reading.shape)
    row = np.arange(len(reading))[:, None]
    lost = np.maximum.accumulate(np.where(begins, row + lasts, 0), axis=0) > row
    anything = np.round(rng.uniform(0.0, 1.3, reading.shape), 3)
    codes = rng.choice(STATUSES, reading.shape)
    status: IntArray = np.where(lost, codes, 0).astype(np.int64)
    return np.where(lost, anything, reading), status
