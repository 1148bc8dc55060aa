"""The proof's own distance sensors: true distances in, readings with noise and faults out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.signal import lfilter

from deltactl.proof.robot.as_built import FloatArray, three
from deltactl.proof.robot.run import Truth

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


Quirk = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Times (n,), true ranges (n, 3) [m], platform velocity (n, 3) [m/s] -> error (n, 3) [m]."""
NOMINAL_OFFSET_M = (0.60, 0.60, 0.90)
EXPOSURE_S = np.linspace(-0.0075, 0.0075, 7)
"""15 ms of timing budget, as the robot file of Zhao's machine sets it."""


@dataclass
class Sensors:
    """What three sensors do wrong; arrays are (3,), for x, y, z."""

    offset_m: FloatArray = field(default_factory=lambda: three(0.0))
    scale: FloatArray = field(default_factory=lambda: three(1.0))
    curvature_per_m: FloatArray = field(default_factory=lambda: three(0.0))
    drift_m: FloatArray = field(default_factory=lambda: three(0.0))
    drift_time_s: FloatArray = field(default_factory=lambda: three(60.0))
    late_s: float = 0.0
    turned_rad: FloatArray = field(default_factory=lambda: three(0.0))
    """Rotation vector by which the sensors see the platform turned."""
    held: list[tuple[int, float, float]] = field(default_factory=list)
    """Sensor, start [s], duration [s] of a repeated value."""
    quirks: list[Quirk] = field(default_factory=list)
    own_lag_s: FloatArray = field(default_factory=lambda: three(0.0))
    """Each sensor's own slowness (first order): in no vocabulary."""


def ideal_ranges(sensors: Sensors, truth: Truth, t_s: FloatArray) -> FloatArray:
    """Readings without noise and without repeated values, (n, 3) [m]."""
    grid_s = truth.t_s
    path = truth.position_m @ turn(sensors.turned_rad).T
    for axis in range(3):
        if sensors.own_lag_s[axis] > 0.0:
            path[:, axis] = _slow(path[:, axis], sensors.own_lag_s[axis], grid_s[1] - grid_s[0])
    distance = np.array(NOMINAL_OFFSET_M) + path
    speed = np.gradient(path, grid_s, axis=0)
    reading = distance + sensors.curvature_per_m * distance**2
    reading = reading * sensors.scale + sensors.offset_m
    reading = reading + sensors.drift_m * -np.expm1(-grid_s[:, None] / sensors.drift_time_s)
    for quirk in sensors.quirks:
        reading = reading + quirk(grid_s, distance, speed)
    seen = np.zeros((len(t_s), 3))
    for moment in EXPOSURE_S:
        for axis in range(3):
            seen[:, axis] += np.interp(t_s - sensors.late_s + moment, grid_s, reading[:, axis])
    return seen / len(EXPOSURE_S)


def read(
    sensors: Sensors, noise: Noise, truth: Truth, t_s: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, IntArray]:
    """Ranges (n, 3) [m] in whole millimetres and statuses (n, 3), 0 = valid."""
    reading = ideal_ranges(sensors, truth, t_s) + wander(noise, len(t_s), rng)
    reading = outliers(noise, reading, rng)
    reading = np.round(np.maximum(reading, 0.0), 3)
    reading, status = dropouts(noise, reading, rng)
    for sensor, start_s, seconds in sensors.held:
        during = np.flatnonzero((t_s >= start_s) & (t_s < start_s + seconds))
        if len(during):
            reading[during, sensor] = reading[during[0], sensor]
            status[during, sensor] = 0
    return reading, status


def turn(vector_rad: FloatArray) -> FloatArray:
    """Rotation matrix (3, 3) of a rotation vector, by its exponential series."""
    x, y, z = vector_rad
    small = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    total, term = np.eye(3), np.eye(3)
    for order in range(1, 12):
        term = term @ small / order
        total = total + term
    return total


def _slow(signal: FloatArray, lag_s: float, step_s: float) -> FloatArray:
    keep = float(np.exp(-step_s / lag_s))
    slow, state = np.empty_like(signal), float(signal[0])
    for k, value in enumerate(signal):
        state = keep * state + (1.0 - keep) * float(value)
        slow[k] = state
    return slow
