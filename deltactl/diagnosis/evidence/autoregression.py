"""Noise of each channel: an autoregression of the model's own residuals, and whitening by it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack

from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray, IntArray, Readings
from deltactl.foundation.scatter import MAD_TO_SIGMA

TINY = float(np.finfo(np.float64).tiny)
AR_ORDER = EVIDENCE.ar_order


@dataclass(frozen=True, eq=False)
class ChannelNoise:
    """Noise of one channel. rows: valid samples that have `AR_ORDER` valid ones before them."""

    rows: IntArray
    """Row numbers, shape (m, AR_ORDER + 1): the sample itself and those before it."""
    phi: FloatArray
    sigma: float
    """Standard deviation of the innovations."""
    spread: float
    """Standard deviation of the readings themselves."""

    @cached_property
    def _read(self) -> tuple[IntArray, IntArray | None]:
        """All rows that are met, and those whitened; None for all that have `AR_ORDER` before."""
        met = np.unique(self.rows)
        at = np.searchsorted(met, self.rows[:, 0]) - AR_ORDER
        return met, None if len(at) == len(met) - AR_ORDER else at

    def whitened(self, values: FloatArray) -> FloatArray:
        """What is new in samples, in standard deviations: (n, ...) -> (m, ...).

        Neighbours are one slice apart once only what was read is left: taken once, not by lags.
        """
        met, at = self._read
        read = values.take(met, axis=0)
        count = len(met) - AR_ORDER
        lags = (read[AR_ORDER - lag : AR_ORDER - lag + count] for lag in range(AR_ORDER + 1))
        white: FloatArray = self.innovations(lags)
        return white if at is None else white.take(at, axis=0)

    def innovations(self, seen: Iterator[Any]) -> Any:
        """What is new in samples, in standard deviations: these first, then those a lag before.

        Arrays of any shape, dense or sparse.
        """
        first, *before = seen
        white = first - float(self.phi[0]) * before[0]
        for phi, earlier in zip(self.phi[1:], before[1:], strict=True):
            white -= float(phi) * earlier
        white /= self.sigma
        return white


@dataclass(frozen=True, slots=True, eq=False)
class Whitener:
    """Turns (n, channels) into one vector of unit independent noise, and weighs outliers down."""

    channels: tuple[ChannelNoise, ...]
    weight: FloatArray
    """Square root of the Huber weight of each whitened value."""

    def __call__(self, values: FloatArray) -> FloatArray:
        """(n, channels) or (n, channels, k) -> (m,) or (m, k)."""
        parts = []
        for column, noise in enumerate(self.channels):
            x = values[:, column]
            if not x.any():
                parts.append(np.zeros((len(noise.rows), *x.shape[1:]), dtype=x.dtype))
                continue
            parts.append(noise.whitened(x))
        joined = np.concatenate(parts)
        weight = self.weight.astype(joined.dtype, copy=False)
        return joined * (weight if joined.ndim == 1 else weight[:, None])

    def at_input(self, change: FloatArray) -> csr_array:
        """From values (n) at a location to what is new in the readings, (m, n).

        change: how the location changes the channels, (n, channels).
        """
        parts = []
        for column, noise in enumerate(self.channels):
            moved = diags_array(change[:, column], format="csr")
            parts.append(noise.innovations(moved[rows] for rows in noise.rows.T))
        return csr_array(diags_array(self.weight) @ vstack(parts, format="csr"))

    @property
    def rows(self) -> IntArray:
        """Row of each whitened value, (m,)."""
        return np.concatenate([noise.rows[:, 0] for noise in self.channels])

    @property
    def channel(self) -> IntArray:
        """Channel of each whitened value, (m,)."""
        return np.concatenate(
            [np.full(len(noise.rows), column) for column, noise in enumerate(self.channels)]
        )

    def weighed(self, residual: FloatArray) -> Whitener:
        """The same with Huber weights from a residual (n, channels)."""
        plain = Whitener(self.channels, np.ones_like(self.weight))(residual)
        weight = np.sqrt(np.minimum(1.0, EVIDENCE.huber / np.maximum(np.abs(plain), 1e-12)))
        return Whitener(self.channels, weight)

    def louder(self, times: float) -> Whitener:
        """The same of noise so many times as large."""
        larger = (replace(x, sigma=times * x.sigma, spread=times * x.spread) for x in self.channels)
        return Whitener(tuple(larger), self.weight)


def history(readings: Readings, valid: Any) -> list[IntArray]:
    """For each channel the rows of its valid samples with their AR_ORDER valid predecessors."""
    stretch = np.cumsum(readings.fresh)
    result = []
    for column in range(len(readings.names)):
        rows = np.flatnonzero(valid[:, column])
        table = np.stack(
            [rows[AR_ORDER - lag : len(rows) - lag] for lag in range(AR_ORDER + 1)], axis=1
        )
        if len(table):
            usual = np.median(np.diff(rows))
            near = table[:, 0] - table[:, -1] <= AR_ORDER * usual + EVIDENCE.longest_hole
            table = table[near & (stretch[table[:, 0]] == stretch[table[:, -1]])]
        result.append(table.reshape(-1, AR_ORDER + 1))
    return result


def estimate(readings: Readings, valid: Any, residual: FloatArray) -> Whitener:
    """Noise model of a residual (n, channels) that a rich enough model has left."""
    channels, centred = channels_of(readings, history(readings, valid), residual)
    size = sum(len(noise.rows) for noise in channels)
    return Whitener(channels, np.ones(size)).weighed(centred)


def channels_of(
    readings: Readings, histories: Iterable[IntArray], residual: FloatArray
) -> tuple[tuple[ChannelNoise, ...], FloatArray]:
    """Noise of each channel, and the residual (n, channels) less its constants.

    A constant in a channel is no noise: the first residual still has it.
    """
    channels, residual = [], residual.copy()
    digits = _digits(readings)
    for column, rows in enumerate(histories):
        if len(rows):
            residual[:, column] -= np.median(residual[rows[:, 0], column])
        x = residual[:, column]
        table = x[rows] if len(rows) else np.zeros((0, AR_ORDER + 1))
        if len(table) < 10 * AR_ORDER:
            channels.append(ChannelNoise(rows[:0], np.zeros(AR_ORDER), 1.0, 1.0))
            continue
        spread = MAD_TO_SIGMA * float(np.median(np.abs(table[:, 0])))
        rounding = max(readings.rounding[column], digits[readings.units[column]])
        spread = max(spread, rounding)
        table = np.clip(table, -4 * spread, 4 * spread)
        gram = table.T @ table / len(table)
        ridge = max(1e-9 * gram[0, 0], TINY)  # readings without any error at all have no memory
        normal = gram[1:, 1:] + ridge * np.eye(AR_ORDER)
        phi: FloatArray = np.linalg.solve(normal, gram[1:, 0])
        phi = stationary(phi)
        innovation = table[:, 0] - table[:, 1:] @ phi
        core = np.abs(innovation) < 4 * MAD_TO_SIGMA * np.median(np.abs(innovation)) + 1e-15
        sigma = max(float(np.std(innovation[core])), 0.3 * rounding)
        channels.append(ChannelNoise(rows, phi, sigma, spread))
    return tuple(channels), residual


def _digits(readings: Readings) -> dict[str, float]:
    """For each unit a share of the readings that few tables have the digits of."""
    found = dict.fromkeys(readings.units, TINY)
    for unit, column in zip(readings.units, readings.values.T, strict=True):
        seen = column[np.isfinite(column)]
        if len(seen):
            found[unit] = max(found[unit], EVIDENCE.digits * float(np.std(seen)))
    return found


def stationary(phi: FloatArray) -> FloatArray:
    """Pull the roots inside 0.98, so that constants and slow changes keep some evidence."""
    while len(phi) and np.abs(np.roots(np.concatenate([[1.0], -phi]))).max() > 0.98:
        phi = phi * 0.97
    return phi
