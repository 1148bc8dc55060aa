"""The model error in each cell of a plane, before and after, and the part that noise explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import chdtri

from deltactl.charts.means import BoolArray, Mismatch
from deltactl.charts.spec import FloatArray

IntArray = np.ndarray[Any, np.dtype[np.int_]]

CELLS = 24
FEWEST = 4
"""Readings a cell needs."""
JOINED = (2, 4)
"""Cells a side that are taken together where each alone has too few readings."""
WITHIN = 0.95
"""Chance of noise alone to stay within its own colour in all cells of a map."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Size of the mean model error in each cell, shape (cells, cells), NaN where it is not known.

    noise: a cell's model error up to this size is no more than noise, shape (cells, cells).
    passed: cells with so few readings around them that they say nothing.
    """

    across: FloatArray
    up: FloatArray
    before: FloatArray
    after: FloatArray
    noise: FloatArray
    passed: BoolArray


def grid_of(across: FloatArray, up: FloatArray, channels: Sequence[Mismatch]) -> Grid | None:
    """Size of the mean model error (over channels) in each cell; None without readings."""
    known = np.isfinite(across) & np.isfinite(up)
    if known.sum() < FEWEST or np.ptp(across[known]) <= 0.0 or np.ptp(up[known]) <= 0.0:
        return None
    # One length a cell both ways, so that the map is not distorted.
    cell = max(float(np.ptp(across[known])), float(np.ptp(up[known]))) / CELLS
    middle = [0.5 * float(v[known].min() + v[known].max()) for v in (across, up)]
    edges = [m + cell * (np.arange(CELLS + 1) - CELLS / 2.0) for m in middle]
    which = [
        np.clip(np.searchsorted(e, np.where(known, v, m), side="right") - 1, 0, CELLS - 1)
        for e, v, m in zip(edges, (across, up), middle, strict=True)
    ]
    flat = which[1] * CELLS + which[0]
    read = known & np.any([np.isfinite(one.before) for one in channels], axis=0)
    numbers = np.bincount(flat[read], minlength=CELLS * CELLS)
    groups = grouped(numbers.reshape(CELLS, CELLS)).ravel()
    drawn = known & (groups[flat] >= 0)
    squares = [_squares(groups[flat], drawn, channels, when) for when in ("before", "after")]
    quiet = _quiet_squares(groups[flat], drawn, channels)
    before, after, noise = (
        np.where(groups >= 0, np.sqrt(square)[groups], np.nan).reshape(CELLS, CELLS)
        for square in (*squares, quiet)
    )
    if not np.isfinite(before).any():
        return None
    passed = (numbers > 0).reshape(CELLS, CELLS) & ~np.isfinite(before)
    return Grid(edges[0], edges[1], before, after, noise, passed)


def grouped(numbers: IntArray) -> IntArray:
    """Which cells are averaged together, as one number for each group; -1 where nothing is.

    numbers: readings in each cell, shape (cells, cells). A cell with enough is used alone. The
    others are joined in squares of JOINED cells a side; the square is filled, unless a
    cell in it has enough readings and so shows where the robot went.
    """
    cells = np.arange(CELLS * CELLS).reshape(CELLS, CELLS)
    rows, columns_ = np.divmod(cells, CELLS)
    groups = np.where(numbers >= FEWEST, cells, -1)
    for turn, side in enumerate(JOINED, 1):
        shape = (CELLS // side, side, CELLS // side, side)
        left = np.where(groups < 0, numbers, 0)
        enough = left.reshape(shape).sum(axis=(1, 3)) >= FEWEST
        empty = (groups < 0).reshape(shape).all(axis=(1, 3))
        enough, empty = (np.kron(x, np.ones((side, side))) > 0 for x in (enough, empty))
        first = rows // side * side * CELLS + columns_ // side * side
        joined = enough & (groups < 0) & ((left > 0) | empty)
        groups = np.where(joined, turn * CELLS * CELLS + first, groups)
    return groups


def _squares(
    groups: IntArray, known: BoolArray, channels: Sequence[Mismatch], when: str
) -> FloatArray:
    """Sum over channels of the squared mean of each group, less what noise adds to it."""
    most = (1 + len(JOINED)) * CELLS * CELLS
    total = np.zeros(most)
    seen = np.zeros(most, dtype=np.bool_)
    for one in channels:
        values: FloatArray = getattr(one, when)
        good = known & np.isfinite(values)
        numbers = np.bincount(groups[good], minlength=most)
        sums = np.bincount(groups[good], weights=values[good], minlength=most)
        enough = numbers >= FEWEST
        total[enough] += (sums[enough] / numbers[enough]) ** 2 - one.spread**2 / numbers[enough]
        seen |= enough
    squares: FloatArray = np.where(seen, np.maximum(total, 0.0), np.nan)
    return squares


def _quiet_squares(groups: IntArray, known: BoolArray, channels: Sequence[Mismatch]) -> FloatArray:
    """The most that `_squares` gives where there is nothing but noise, in all groups together."""
    most = (1 + len(JOINED)) * CELLS * CELLS
    variance, degrees = np.zeros(most), np.zeros(most)
    for one in channels:
        numbers = np.bincount(groups[known & np.isfinite(one.after)], minlength=most)
        enough = numbers >= FEWEST
        variance[enough] += one.spread**2 / numbers[enough]
        degrees[enough] += 1.0
    degrees = np.maximum(degrees, 1.0)
    each = (1.0 - WITHIN) / max(1, int(np.count_nonzero(variance)))
    squares: FloatArray = variance * np.maximum(chdtri(degrees, each) / degrees - 1.0, 0.0)
    return squares
