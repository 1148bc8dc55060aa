"""What light a simulated VL53L1X sees, what it makes of it, and how its samples scatter.

The shapes are physics (return falls with the square of the distance, scatter with shot noise,
phase is time of flight in clocks of the PLL); the constants are chosen so that the figures
are those of a white target on a breakout board. Noise is repeatable from a seed.

Does not model: the SPAD array (always 128 SPADs), crosstalk of a cover glass, the field of
view (one flat target), temperature, or several targets.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class RangeNoise:
    """How a sensor's samples scatter: AR(1) from sample to sample, plus rare outliers.

    `correlation` is that of neighbouring samples; `sigma_m` the standard deviation of each.
    """

    sigma_m: float = 0.0015
    correlation: float = 0.0
    outlier_rate: float = 0.0
    """Part of the samples."""
    outlier_m: float = 0.1
    """Standard deviation of an outlier."""
    seed: int = 1

    def source(self) -> NoiseSource:
        """A fresh sequence."""
        return NoiseSource(self)


class NoiseSource:
    """One error after the other; the sequence does not depend on when it is asked for."""

    def __init__(self, noise: RangeNoise):
        self._noise = noise
        self._random = random.Random(noise.seed)
        self._innovation = math.sqrt(1.0 - noise.correlation**2)
        self._state = self._random.gauss(0.0, 1.0)

    def next_m(self) -> float:
        """The error of the next sample at nominal light [m]."""
        noise, source = self._noise, self._random
        self._state = noise.correlation * self._state + self._innovation * source.gauss(0.0, 1.0)
        error_m = noise.sigma_m * self._state
        if noise.outlier_rate > 0.0 and source.random() < noise.outlier_rate:
            error_m += source.gauss(0.0, noise.outlier_m)
        return error_m


SIGNAL_MCPS_M2 = 4.0
"""Return rate of a white target at 1 m."""
LARGEST_RATE_MCPS = 200.0
NOMINAL_AMBIENT_MCPS = 0.1
SIGMA_MM = 9.0
"""Sigma = this * sqrt(signal + ambient) / signal for 8 ms of collection."""
SIGMA_COLLECTION_NS = 8e6
HALF_LIGHT_M_PER_NS = 0.149896229

RANGE_COMPLETE, SIGMA_FAIL, NO_TARGET, MIN_CLIP, PHASE_FAIL = 9, 6, 4, 8, 5
SPADS = 128


@dataclass
class Scene:
    """Light and target in front of a sensor; may be changed while it ranges."""

    ambient_mcps: float = NOMINAL_AMBIENT_MCPS
    reflectance: float = 1.0
    wrap_m: float | None = None
    """Distances come back modulo this, with a valid status (an aliased target)."""


class Limits(NamedTuple):
    """The chip's own thresholds, from its registers."""

    sigma_mm: float
    signal_mcps: float
    phase_clocks: float


class Seen(NamedTuple):
    """What a range found. `scatter` multiplies the noise that holds at nominal light."""

    distance_m: float
    raw_status: int
    signal_mcps: float
    ambient_mcps: float
    sigma_mm: float
    phase_clocks: float
    scatter: float


def look(
    scene: Scene, distance_m: float, collection_ns: float, pll_period_ns: float, limits: Limits
) -> Seen:
    """One range at a target; a distance that is not finite means that there is none."""
    if not math.isfinite(distance_m):
        return Seen(0.0, NO_TARGET, 0.0, scene.ambient_mcps, 0.0, 0.0, 1.0)
    shown_m = distance_m if scene.wrap_m is None else distance_m % scene.wrap_m
    reach_m = max(distance_m, 0.02)
    signal = min(SIGNAL_MCPS_M2 * scene.reflectance / reach_m**2, LARGEST_RATE_MCPS)
    ambient = scene.ambient_mcps
    exposure = math.sqrt(SIGMA_COLLECTION_NS / max(collection_ns, 1.0))
    sigma_mm = SIGMA_MM * math.sqrt(signal + ambient) / max(signal, 1e-3) * exposure
    phase = max(shown_m, 0.0) / (HALF_LIGHT_M_PER_NS * pll_period_ns)
    scatter = math.sqrt((signal + ambient) / (signal + NOMINAL_AMBIENT_MCPS))
    status = _status(signal, sigma_mm, phase, shown_m, limits)
    return Seen(shown_m, status, signal, ambient, sigma_mm, phase, scatter)


def _status(
    signal_mcps: float, sigma_mm: float, phase_clocks: float, shown_m: float, limits: Limits
) -> int:
    if signal_mcps < limits.signal_mcps:
        return NO_TARGET
    if phase_clocks > limits.phase_clocks:
        return PHASE_FAIL
    if shown_m <= 0.0:
        return MIN_CLIP
    if sigma_mm > limits.sigma_mm:
        return SIGMA_FAIL
    return RANGE_COMPLETE
