"""How many independent readings a recording holds: a saturated residual, counted by its memory.

558 filtered readings of one joint carry as much information as 20. What a rich model leaves is
correlated, some of it is model discrepancy that no effect explains; a likelihood that takes it for
independent noise is sure of everything. So the likelihood is tempered: the variance is multiplied
by the integrated autocorrelation time of that residual (Sokal 1997, Monte Carlo Methods in
Statistical Mechanics, section 3), for each kind of row by itself (at rest and in motion, each
joint).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from deltactl.diagnosis.evidence.memory_given_back import autocorrelation_times, given_back
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.foundation.scatter import MAD_TO_SIGMA


@dataclass(frozen=True, slots=True, eq=False)
class TemperedNoise:
    """Whitening of (n,) or (n, k) to the rows that count, each in tempered standard deviations."""

    rows: IntArray
    scale: FloatArray
    """(m,) weight / (sigma sqrt(tau)) of each row."""
    sigma: FloatArray
    """(m,) standard deviation of one reading."""
    tau: float
    """Readings that tell as much as one independent one."""
    count: float
    """Readings, those that repeat a rounded value counted once."""
    sampled: FloatArray | None = None
    """(m,) share of the variance of each row that does not lie between samples; None: all of it."""

    def whiten(self, values: FloatArray) -> FloatArray:
        """Rows that count, in standard deviations."""
        chosen = values[self.rows]
        return chosen * (self.scale if chosen.ndim == 1 else self.scale[:, None])

    @property
    def untempered(self) -> TemperedNoise:
        """The same as if all readings were independent: for the best fit, not for its evidence."""
        return replace(self, scale=self.scale * np.sqrt(self.tau), tau=1.0)

    def rms(self, left: FloatArray) -> float:
        """Root mean square over rows (m,), each by the share of its variance that is sampled."""
        return root_mean_square(left, self.sampled)

    @property
    def size(self) -> float:
        """Standard deviation of one reading, over all rows."""
        return float(np.sqrt(np.mean(self.sigma**2)))

    @property
    def effective(self) -> float:
        """Effective number of readings."""
        return self.count / self.tau


def root_mean_square(values: FloatArray, weights: FloatArray | None = None) -> float:
    """Root of the weighted mean of squares; 0 of nothing."""
    return float(np.sqrt(np.average(np.square(values), weights=weights))) if len(values) else 0.0


def spare(effective: float, fitted: float) -> float:
    """Independent readings that tell how large the noise is, with so many sizes fitted: sizes that
    a prior holds do not take a whole reading each, so at most a share of all is taken.
    """
    return max(effective - min(fitted, EVIDENCE.most_taken * effective), 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """The rows of a residual (n,) that count, and how each was read."""

    rows: IntArray
    groups: IntArray
    """(m,) recordings."""
    kinds: IntArray
    """(n,) among which single readings are outliers."""
    noises: IntArray
    """(n,) which have the noise of the noisiest kind among them."""
    least: float
    """Standard deviation of rounding, below which no noise is accepted."""
    once: IntArray | None = None
    """(m,) number of the run of equal values that each row lies in."""
    unsampled: FloatArray | None = None
    """(n,) standard deviation of what a row owes to the course of the command between samples."""
    asked: IntArray | None = None
    """(m,) number of the place that was commanded,"""
    asked_rounding: float = 0.0
    """and the standard deviation of its rounding, which is the same each time at one place."""


def tempered(
    residual: FloatArray, read: Rows, fitted: int = 0, took: FloatArray | None = None
) -> TemperedNoise:
    """Noise of a saturated residual (n,).

    fitted: numbers the saturated model took. took: (m, p) its shapes in standard deviations of the
    noise and of their sizes, where the noise with a memory that they absorbed is to be restored.
    """
    rows = read.rows
    left = residual[rows]
    extra = np.zeros(len(rows)) if read.unsampled is None else read.unsampled[rows]
    once = np.arange(len(rows)) if read.once is None else read.once
    single = 1.0 / np.sqrt(np.bincount(once)[once])
    if read.asked is not None:
        times = np.bincount(read.asked, single**2)[read.asked]
        extra = np.hypot(extra, read.asked_rounding * np.sqrt(times))
    weight = spike_weights(left, read.kinds[rows]) * single
    sigma = _by_kind(read, left, weight, extra)
    sampled = sigma**2 / (sigma**2 + extra**2)
    sigma = np.hypot(sigma, extra)
    count = float(once[-1]) + 1.0
    new = np.concatenate([[True], np.diff(once) > 0])
    apart = read.groups[rows][new]
    most = EVIDENCE.clipped_at
    standard = np.clip((left / sigma)[new], -most, most)
    tau = float(autocorrelation_times(standard[:, None], apart)[0])
    if took is not None and took.shape[1]:
        back = given_back(took[new] / single[new, None], apart, tau)
        sigma = sigma * np.sqrt(min(back.variance, EVIDENCE.most_given_back))
        tau = tau * back.memory
    tau = min(tau, max(count / EVIDENCE.fewest_effective, 1.0))
    if took is None:
        sigma = sigma * np.sqrt(count / tau / spare(count / tau, fitted))
    return TemperedNoise(rows, weight / (sigma * np.sqrt(tau)), sigma, tau, count, sampled)


def _by_kind(read: Rows, left: FloatArray, weight: FloatArray, extra: FloatArray) -> FloatArray:
    """Standard deviation (m,) of each kind, that of the noisiest where several share it."""
    kinds, noises = read.kinds[read.rows], read.noises[read.rows]
    sigma = np.empty(len(left))
    for kind in np.unique(kinds):
        own = kinds == kind
        sigma[own] = max(_apart_from(extra[own], left[own], weight[own] ** 2), read.least)
    for noise in np.unique(noises):
        own = noises == noise
        sigma[own] = float(sigma[own].max())
    return sigma


def _apart_from(extra: FloatArray, left: FloatArray, weights: FloatArray) -> float:
    """Standard deviation of weighted readings (m,) beside the part of each that is known."""
    sigma = root_mean_square(left, weights)
    for _ in range(EVIDENCE.unsampled_rounds if np.any(extra) and sigma > 0.0 else 0):
        sigma = root_mean_square(left, weights * sigma**2 / (sigma**2 + extra**2))
    return sigma


def runs_of_one_value(
    values: FloatArray, expected: FloatArray, groups: IntArray, rows: IntArray
) -> IntArray:
    """Number (m,) of the run of equal rounded values that each row lies in; a run tells once.

    While a machine rests, rounding is off by the same amount each time: nothing new is learned.
    Where what is expected (n,) leaps, a machine that still rests shows how late it is.
    """
    chosen, group, moved = values[rows], groups[rows], np.abs(np.diff(expected[rows]))
    leap = moved > max(EVIDENCE.leap * float(np.ptp(expected[rows])), 1e-300)
    new = (np.diff(chosen) != 0.0) | (np.diff(group) != 0) | leap
    number: IntArray = np.concatenate([[0], np.cumsum(new)]).astype(np.intp)
    return number


def spike_weights(left: FloatArray, kinds: IntArray) -> FloatArray:
    """Weights (m,) that take single readings far off their neighbours down, Huber's way.

    kinds: (m,) a reading is held against those of its kind, and all: a machine that comes after its
    command within a few samples leaves spikes in every move and none at rest, and these say how
    late it is. What lasts for several readings is signal, however large.
    """
    weight = np.ones(len(left))
    if len(left) < OBSERVATIONS.neighbours:
        return weight
    off = np.abs(left - median_filter(left, OBSERVATIONS.neighbours, mode="nearest"))
    of_all = _usual(off)
    for kind in np.unique(kinds):
        own = kinds == kind
        usual = max(of_all, _usual(off[own]))
        weight[own] = EVIDENCE.spike_limit * usual / np.maximum(off[own], 1e-300)
    return np.where(weight < EVIDENCE.spike_weight, weight, 1.0)


def _usual(off: FloatArray) -> float:
    """How far a reading usually is off its neighbours."""
    large = EVIDENCE.spike_share * float(np.quantile(off, EVIDENCE.spike_quantile))
    return max(MAD_TO_SIGMA * float(np.median(off)), large, 1e-300)
