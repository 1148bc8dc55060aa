"""Noise of channels that lie end to end: an autoregression for each, from a saturated fit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from deltactl.diagnosis.evidence.autoregression import Whitener, estimate
from deltactl.diagnosis.evidence.effective_size import TemperedNoise, root_mean_square, spare
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, Readings
from deltactl.diagnosis.plants.delta.point import side_by_side


@dataclass(frozen=True, slots=True, eq=False)
class ChannelsNoise(TemperedNoise):
    """Whitening by what is new in a sample, and Huber's weights."""

    whitener: Whitener = field(default_factory=lambda: Whitener((), np.zeros(0)))
    counts: FloatArray = field(default_factory=lambda: np.zeros(0))
    """(m,) 1 where a reading is in the unit of the figures, else 0."""

    def rms(self, left: FloatArray) -> float:
        """Root mean square over the rows (m,) that are in the unit of the figures."""
        return root_mean_square(left, self.counts)

    @property
    def size(self) -> float:
        """Standard deviation of one reading, over such rows."""
        return self.rms(self.sigma)

    def whiten(self, values: FloatArray) -> FloatArray:
        """What is new in rows that count, in standard deviations."""
        channels = side_by_side(values, len(self.whitener.channels))
        white = self.whitener(channels)
        weight = self.scale * self.sigma
        return white * (weight if white.ndim == 1 else weight[:, None])


def in_figures(readings: Readings) -> FloatArray:
    """1 for each channel (c,) that figures of the model error are of, those in metres; else 0."""
    unit = "m" if "m" in readings.units else readings.units[0]
    return np.array([float(one == unit) for one in readings.units])


def noise_of(whitener: Whitener, readings: Readings) -> ChannelsNoise:
    """The noise by which a whitener works."""
    spread = np.array([one.spread for one in whitener.channels])[whitener.channel]
    plain = Whitener(whitener.channels, np.ones_like(whitener.weight))
    at = whitener.rows + len(readings.t_s) * whitener.channel
    scale = whitener.weight / spread
    counts = in_figures(readings)[whitener.channel]
    return ChannelsNoise(at, scale, spread, 1.0, float(len(at)), None, plain, counts)


class SaturatedFit:
    """Least squares of many columns together, (n c, p) as they are in the channels."""

    def __init__(self, columns: FloatArray, whitener: Whitener):
        self._columns: Any = columns.astype(np.float32)
        self._white = whitener(side_by_side(self._columns, len(whitener.channels)))
        self._whitener = whitener
        gram = np.asarray(self._white.T @ self._white, dtype=np.float64)
        self._scale = np.sqrt(np.maximum(np.diag(gram), 1e-30))
        matrix = gram / np.outer(self._scale, self._scale)
        matrix += EVIDENCE.ridge * np.eye(len(gram))
        values, vectors = np.linalg.eigh(matrix)
        first = max(len(values) - len(self._white) // EVIDENCE.readings_a_column, 0)
        self._values, self._vectors = values[first:], vectors[:, first:]
        fitted = float(np.sum(1.0 - EVIDENCE.ridge / self._values))
        self.louder = float(np.sqrt(len(self._white) / spare(float(len(self._white)), fitted)))
        """How many times larger the noise is than what its own fit leaves of it."""

    def __call__(self, residual: FloatArray) -> FloatArray:
        """What the columns explain of a residual, (n, channels)."""
        white = self._whitener(residual).astype(np.float32)
        along = np.asarray(self._white.T @ white, dtype=np.float64)
        shares = self._vectors.T @ (along.T / self._scale).T
        sizes = ((self._vectors @ (shares.T / self._values).T).T / self._scale).T
        explained = self._columns @ sizes.astype(np.float32)
        return side_by_side(np.asarray(explained, dtype=np.float64), residual.shape[1])


def fast_noise(readings: Readings, valid: BoolArray, residual: FloatArray) -> ChannelsNoise:
    """By second differences of a residual (n c,): what is not smooth in it, as white noise."""
    channels = side_by_side(residual, len(readings.names))
    fast = np.zeros_like(channels)
    fast[1:-1] = np.diff(channels, 2, axis=0) / np.sqrt(6.0)
    return noise_of(estimate(readings, valid, fast), readings)


def saturated_noise(
    readings: Readings,
    valid: BoolArray,
    residual: FloatArray,
    columns: FloatArray,
    before: ChannelsNoise,
    rounds: int = EVIDENCE.noise_rounds,
) -> ChannelsNoise:
    """Noise of what all columns (n c, p) together leave of a residual (n c,)."""
    channels = side_by_side(residual, len(readings.names))
    plain, weight = before.whitener, before.scale * before.sigma
    whitener = Whitener(plain.channels, weight)
    for _ in range(rounds):
        fit = SaturatedFit(columns, whitener)
        left = channels - fit(channels)
        whitener = estimate(readings, valid, left)
    return noise_of(whitener.louder(fit.louder), readings)
