"""Noise of a simulated ranging sensor: correlated, with outliers, repeatable from a seed."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass


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
