"""Three ranging sensors as they are: from where the platform was to what is written down.

Order: turned frame, lateness, averaging over the timing budget, curvature, scale, offset, drift,
unnamed errors, noise, outliers, rounding, dropouts, repeated values. A reading's time is the
middle of its exposure, so averaging alone makes nothing late.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from deltactl.proof.robot.as_built import FloatArray, three
from deltactl.proof.robot.run import Truth
from deltactl.proof.sensors.noise import Noise, dropouts, outliers, wander

Quirk = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
"""Times (n,), true ranges (n, 3) [m], platform velocity (n, 3) [m/s] -> error (n, 3) [m]."""
IntArray = np.ndarray[Any, np.dtype[np.int64]]
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
