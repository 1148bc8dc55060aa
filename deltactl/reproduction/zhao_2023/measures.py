"""Sizes of tracking errors."""

from __future__ import annotations

import numpy as np

from deltactl.models.robot import FloatArray


def rms_m(error_m: FloatArray) -> FloatArray:
    """Root mean square per axis, (3,), of errors (n, 3); NaN left out."""
    rms: FloatArray = np.sqrt(np.nanmean(error_m**2, axis=0))
    return rms


def greatest_m(error_m: FloatArray) -> FloatArray:
    """Largest size per axis, (3,); NaN left out."""
    largest: FloatArray = np.nanmax(np.abs(error_m), axis=0)
    return largest


def distance_m(error_m: FloatArray) -> float:
    """Root mean square of the distance, over rows without NaN."""
    return float(np.sqrt(np.nanmean(np.sum(error_m**2, axis=1))))


def slow_m(error_m: FloatArray, window: int = 25) -> FloatArray:
    """A running mean over half a second of readings: noise taken off, for figures; (n, 3)."""
    known = np.isfinite(error_m)
    kernel = np.ones(window)
    columns = []
    for axis in range(error_m.shape[1]):
        total = np.convolve(np.where(known[:, axis], error_m[:, axis], 0.0), kernel, "same")
        count = np.convolve(known[:, axis].astype(np.float64), kernel, "same")
        columns.append(total / np.maximum(count, 1.0))
    return np.stack(columns, axis=1)
