"""Means of the model error over neighbours in time or in a covariate, and the effect of noise.

In: readings before and after, shape (n,), in the unit that is drawn. Out: curves and figures.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np

from deltactl.charts.spec import FloatArray
from deltactl.foundation.scatter import MAD_TO_SIGMA

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]

OUTLIER_SIGMAS = 7.0
"""Readings further from the median than this are few where the residual is noise,"""
REACH = 3.0
"""and are drawn up to so many times the range of the others: those keep a sixth of the height."""
BUCKETS = 1200
SMOOTHED_OVER = 5
"""Buckets a smoothed curve averages over at most."""
FEWEST_IN_BUCKET = (2, 3)
"""At least two: a bucket that is empty by chance is a gap, and a line between two gaps is none."""
BINS = 24
FEWEST_BINS = 2
"""A curve has two points at least."""
HARDLY = 1e-6
"""A covariate that varies by less than this part of its size does not vary."""
WITHIN = 0.95
"""Chance of noise alone to stay within the band at all points of a curve."""
FEWEST_IN_BIN = 12
NARROWEST = 0.01
"""Share of a covariate's range that a bin spans at least."""


@dataclass(frozen=True, slots=True, eq=False)
class Mismatch:
    """One channel. before, after: shape (n,), NaN where nothing valid was read, it lies far out, or
    the fit took it for an outlier: what means are of.

    readings: before, shape (n,), with the outliers of the fit that do not lie far out.
    far_out: readings so far out that they would hide everything else.
    all_before, all_after: shape (n,), with those that lie far out, without those that the fit took
    for outliers: as the figures of the fit.
    """

    name: str
    unit: str
    source: str
    """Column of the recording."""
    source_unit: str
    before: FloatArray
    after: FloatArray
    noise: float
    readings: FloatArray
    far_out: int
    all_before: FloatArray
    all_after: FloatArray
    share: FloatArray
    """How much each reading counts in the figures of the fit, shape (n,)."""

    @property
    def unchanged(self) -> bool:
        """Nothing was found that changes the prediction."""
        return bool(np.array_equal(self.before, self.after, equal_nan=True))

    @property
    def spread(self) -> float:
        """Standard deviation of what is left, widened so that means of n scatter by it / sqrt n."""
        left = self.after[np.isfinite(self.after)]
        return float(np.std(left)) * variance_inflation(left) if len(left) else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Means over neighbours; arrays of shape (k,). spread: what noise alone does to a mean."""

    x: FloatArray
    before: FloatArray
    after: FloatArray
    spread: FloatArray

    @property
    def band(self) -> FloatArray:
        """Half the width that noise alone keeps to at all points of a curve together (Sidak)."""
        if not len(self.x):
            return self.spread
        each = WITHIN ** (1.0 / len(self.x))
        return NormalDist().inv_cdf(0.5 * (1.0 + each)) * self.spread


def far_out(values: FloatArray) -> BoolArray:
    """Which of the values (n,) would squeeze all others to a line if they were drawn."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return np.zeros(len(values), dtype=np.bool_)
    middle = float(np.median(finite))
    spread = MAD_TO_SIGMA * float(np.median(np.abs(finite - middle)))
    if spread <= 0.0:
        return np.zeros(len(values), dtype=np.bool_)
    usual = np.ptp(finite[np.abs(finite - middle) <= OUTLIER_SIGMAS * spread])
    far: BoolArray = np.abs(values - middle) > max(OUTLIER_SIGMAS * spread, REACH * float(usual))
    return far


def smoothed(t_s: FloatArray, one: Mismatch) -> Curve:
    """Means over short stretches of time; NaN (a gap) where there are no readings."""
    known = np.isfinite(t_s) & np.isfinite(one.before)
    if not known.any():
        return Curve(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0))
    start, end = float(t_s[known].min()), float(t_s[known].max())
    wanted = _readings_to_average(one)
    fewest = int(np.clip(wanted, *FEWEST_IN_BUCKET))
    count = int(np.clip(known.sum() // fewest, 1, BUCKETS))
    window = int(np.clip(np.ceil(wanted * count / known.sum()), 1, min(SMOOTHED_OVER, count)))
    edges = np.linspace(start, end, count + 1)
    middles = (edges[1:] + edges[:-1]) / 2.0
    after_edge = np.searchsorted(edges, np.where(known, t_s, start), side="right")
    where = np.clip(after_edge - 1, 0, count - 1)
    before, after = (_rolling(where, values, count, window) for values in (one.before, one.after))
    return Curve(middles, before, after, np.full(count, np.nan))


def _readings_to_average(one: Mismatch) -> int:
    """How many it takes for the noise to be a tenth of the model error's own spread."""
    spread = float(np.nanstd(one.before))
    if not (one.noise > 0.0 and spread > 0.0):
        return 1
    return int(np.clip((one.noise / (0.1 * spread)) ** 2, 1.0, 1000.0))


def _rolling(where: Any, values: FloatArray, count: int, buckets: int) -> FloatArray:
    good = np.isfinite(values)
    sums = np.bincount(where[good], weights=values[good], minlength=count)
    numbers = np.bincount(where[good], minlength=count).astype(np.float64)
    window = np.ones(buckets)
    total = np.convolve(sums, window, mode="same")
    weight = np.convolve(numbers, window, mode="same")
    mean: FloatArray = np.where(numbers > 0, total / np.maximum(weight, 1.0), np.nan)
    return mean


def binned(covariate: FloatArray, one: Mismatch) -> Curve:
    """Mean model error over stretches of a covariate that hold equally many readings.

    Empty where fewer than two stretches hold enough of them: the covariate hardly varies.
    """
    nothing = np.zeros(0)
    good = np.isfinite(covariate) & np.isfinite(one.before) & np.isfinite(one.after)
    values = covariate[good]
    if good.sum() < 2 * FEWEST_IN_BIN or np.ptp(values) <= HARDLY * np.abs(values).max():
        return Curve(nothing, nothing, nothing, nothing)
    bins = int(np.clip(good.sum() // FEWEST_IN_BIN, 2, BINS))
    # A covariate that mostly holds one value (a speed of 0) gives fewer, fuller bins.
    edges = _apart(np.quantile(values, np.linspace(0.0, 1.0, bins + 1)))
    where = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    numbers = np.bincount(where, minlength=len(edges) - 1)
    filled = numbers >= min(FEWEST_IN_BIN, int(numbers.max()))
    if filled.sum() < FEWEST_BINS:
        return Curve(nothing, nothing, nothing, nothing)

    def mean(of: FloatArray) -> FloatArray:
        sums = np.bincount(where, weights=of, minlength=len(numbers))
        means: FloatArray = sums[filled] / numbers[filled]
        return means

    spread = one.spread / np.sqrt(numbers[filled])
    return Curve(mean(values), mean(one.before[good]), mean(one.after[good]), spread)


def _apart(edges: FloatArray) -> FloatArray:
    """Edges at least NARROWEST of the whole apart; the first and the last stay."""
    least = NARROWEST * float(edges[-1] - edges[0])
    kept = [float(edges[0])]
    for edge in edges[1:-1].tolist():
        if edge - kept[-1] >= least and edges[-1] - edge >= least:
            kept.append(edge)
    return np.array([*kept, float(edges[-1])])


def variance_inflation(values: FloatArray) -> float:
    """How much more the mean of correlated readings scatters (first-order correlation)."""
    steps = values - values.mean()
    power = float(steps @ steps)
    together = float(steps[1:] @ steps[:-1]) / power if power > 0.0 else 0.0
    together = min(max(together, 0.0), 0.98)
    return float(np.sqrt((1.0 + together) / (1.0 - together)))


def explained_by(curve: Curve) -> float:
    """How far the means before exceed what noise alone would give, as a mean square."""
    if len(curve.x) < 2:
        return 0.0
    off = curve.before - float(np.mean(curve.before))
    return float(np.mean((off / np.maximum(curve.spread, 1e-300)) ** 2))


def rms(values: FloatArray, chosen: BoolArray, share: FloatArray | None = None) -> float:
    """Root mean square of the known values of a selection; NaN when there are none.

    share: how much each value counts; None: all alike.
    """
    known = chosen & np.isfinite(values)
    weights = None if share is None else share[known]
    counts = known.any() if weights is None else weights.any()
    return float(np.sqrt(np.average(values[known] ** 2, weights=weights))) if counts else math.nan
