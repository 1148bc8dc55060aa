"""The mismatch (observed minus predicted) in people's units, smoothed, binned, and by regime."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from diagnosis.report import words
from diagnosis.report.sizes import scale_of
from diagnosis.result import Channel, FloatArray, Picture

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]

OUTLIER_SIGMAS = 7.0
MAD_TO_SIGMA = 1.4826
BUCKETS = 1200
SMOOTHED_OVER = 5
"""Buckets a smoothed curve averages over."""
FEWEST_IN_BUCKET = 3
BINS = 28
FEWEST_IN_BIN = 8


@dataclass(frozen=True, slots=True, eq=False)
class Mismatch:
    """One channel. before, after: shape (n,), NaN where nothing valid was read or it lies far out.

    far_out: readings that stand so far out that they would hide everything else.
    """

    name: str
    unit: str
    source: str
    """Column of the recording."""
    source_unit: str
    before: FloatArray
    after: FloatArray
    noise: float
    far_out: int


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Means over neighbours; x, before, after of shape (k,)."""

    x: FloatArray
    before: FloatArray
    after: FloatArray


def mismatches(picture: Picture) -> list[Mismatch]:
    """All channels with at least one valid reading."""
    found = (_mismatch(channel) for channel in picture.channels)
    return [one for one in found if np.isfinite(one.before).any()]


def _mismatch(channel: Channel) -> Mismatch:
    scale = scale_of(channel.unit)
    before = (channel.observed - channel.before) * scale.factor
    after = (channel.observed - channel.after) * scale.factor
    far = _far_out(before) & _far_out(after)
    return Mismatch(
        name=words.channel(channel.name),
        unit=scale.unit,
        source=channel.name,
        source_unit=channel.unit,
        before=np.where(far | ~np.isfinite(before), np.nan, before),
        after=np.where(far | ~np.isfinite(after), np.nan, after),
        noise=channel.noise * scale.factor,
        far_out=int(far.sum()),
    )


def _far_out(values: FloatArray) -> BoolArray:
    finite = values[np.isfinite(values)]
    if not len(finite):
        return np.zeros(len(values), dtype=np.bool_)
    middle = float(np.median(finite))
    spread = MAD_TO_SIGMA * float(np.median(np.abs(finite - middle)))
    far: BoolArray = np.abs(values - middle) > OUTLIER_SIGMAS * spread
    return far if spread > 0.0 else np.zeros(len(values), dtype=np.bool_)


def smoothed(t_s: FloatArray, one: Mismatch) -> Curve:
    """Means over short stretches of time; NaN (a gap) where there are no readings."""
    known = np.isfinite(t_s)
    if not known.any():
        return Curve(np.zeros(0), np.zeros(0), np.zeros(0))
    start, end = float(t_s[known].min()), float(t_s[known].max())
    count = int(np.clip(known.sum() // FEWEST_IN_BUCKET, 1, BUCKETS))
    edges = np.linspace(start, end, count + 1)
    middles = (edges[1:] + edges[:-1]) / 2.0
    after_edge = np.searchsorted(edges, np.where(known, t_s, start), side="right")
    where = np.clip(after_edge - 1, 0, count - 1)
    before, after = (_rolling(where, values, count) for values in (one.before, one.after))
    return Curve(middles, before, after)


def _rolling(where: Any, values: FloatArray, count: int) -> FloatArray:
    good = np.isfinite(values)
    sums = np.bincount(where[good], weights=values[good], minlength=count)
    numbers = np.bincount(where[good], minlength=count).astype(np.float64)
    window = np.ones(min(SMOOTHED_OVER, count))
    total = np.convolve(sums, window, mode="same")
    weight = np.convolve(numbers, window, mode="same")
    mean: FloatArray = np.where(numbers > 0, total / np.maximum(weight, 1.0), np.nan)
    return mean


def binned(driver: FloatArray, one: Mismatch) -> Curve:
    """Mean mismatch over equal steps of a driver; NaN where there are too few readings."""
    good = np.isfinite(driver) & np.isfinite(one.before) & np.isfinite(one.after)
    if good.sum() < FEWEST_IN_BIN or np.ptp(driver[good]) <= 0.0:
        return Curve(np.zeros(0), np.zeros(0), np.zeros(0))
    # The outermost half percent on each side would stretch the picture.
    low, high = np.quantile(driver[good], [0.005, 0.995])
    if high <= low:
        low, high = float(driver[good].min()), float(driver[good].max())
    edges = np.linspace(low, high, BINS + 1)
    where = np.clip(np.searchsorted(edges, driver[good], side="right") - 1, 0, BINS - 1)
    numbers = np.bincount(where, minlength=BINS)
    enough = numbers >= FEWEST_IN_BIN

    def mean(values: FloatArray) -> FloatArray:
        sums = np.bincount(where, weights=values[good], minlength=BINS)
        means: FloatArray = np.where(enough, sums / np.maximum(numbers, 1), np.nan)
        return means

    return Curve((edges[1:] + edges[:-1]) / 2.0, mean(one.before), mean(one.after))


def explained_by(driver: FloatArray, one: Mismatch) -> float:
    """How much of the mismatch's power goes with the driver, less what chance alone gives."""
    curve = binned(driver, one)
    means = curve.before[np.isfinite(curve.before)]
    total = float(np.nanvar(one.before))
    if len(means) < 4 or total <= 0.0:
        return 0.0
    return max(0.0, float(np.var(means)) / total - 1.0 / FEWEST_IN_BIN / len(means))


def rms(values: FloatArray, chosen: BoolArray) -> float:
    """Root mean square of the known values of a selection; NaN when there are none."""
    found = values[chosen & np.isfinite(values)]
    return float(np.sqrt(np.mean(found**2))) if len(found) else float("nan")
