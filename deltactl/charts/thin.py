"""Fewer points for the same picture: peaks stay where they are."""

from __future__ import annotations

from typing import Any

import numpy as np

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
Index = np.ndarray[Any, np.dtype[np.intp]]

MAXIMUM_POINTS = 20_000
"""More than any screen has columns; zooming in still finds the peaks of every bucket."""


def keep(x: FloatArray, y: FloatArray, maximum: int = MAXIMUM_POINTS) -> Index:
    """Indices of at most about `maximum` points, in order.

    A curve over increasing `x` keeps the lowest and highest point (and the first gap) of every
    bucket; any other curve keeps every k-th point.
    """
    n = len(x)
    if n <= maximum:
        return np.arange(n)
    if not is_increasing(x):
        return np.append(np.arange(0, n - 1, -(-n // maximum)), n - 1)
    starts = np.linspace(0, n, max(1, maximum // 3) + 1).astype(np.intp)[:-1]
    kept: Index = np.unique(np.concatenate([[0, n - 1], *_extremes(y, starts)]))
    return kept


def is_increasing(x: FloatArray) -> bool:
    """Whether `x` never goes back (and holds no NaN)."""
    return bool(np.all(np.diff(x) >= 0.0)) and not bool(np.isnan(x).any())


def _extremes(y: FloatArray, starts: Index) -> list[Index]:
    """Per bucket the index of its lowest, highest and first missing value."""
    found: list[list[int]] = [[], [], []]
    missing = np.isnan(y)
    low, high = np.where(missing, np.inf, y), np.where(missing, -np.inf, y)
    for start, end in zip(starts, [*starts[1:], len(y)], strict=True):
        found[0].append(start + int(np.argmin(low[start:end])))
        found[1].append(start + int(np.argmax(high[start:end])))
        found[2].append(start + int(np.argmax(missing[start:end])))
    return [np.array(part, dtype=np.intp) for part in found]
