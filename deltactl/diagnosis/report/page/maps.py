"""Maps of the workspace: how large the mismatch is at each place, before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import chdtri

from deltactl.charts.page import columns, paragraph
from deltactl.diagnosis.answer.picture import FloatArray
from deltactl.diagnosis.report.page.residuals import BoolArray, Mismatch
from deltactl.diagnosis.report.phrases import words
from deltactl.diagnosis.report.phrases.sizes import number, significant

IntArray = np.ndarray[Any, np.dtype[np.int_]]

CELLS = 24
FEWEST = 4
"""Readings a cell needs."""
JOINED = (2, 4)
"""Cells a side that are taken together where each alone has too few readings."""
LEVELS = 6
TOP_SHARE = 0.98
"""The darkest colour starts at this quantile of the cells before; one wild cell does not rule."""
QUIET_SIGMAS = 2.0
"""The darkest colour stands for at least so many standard deviations of a reading."""
WITHIN = 0.95
"""Chance of noise alone to stay within its own colour in all cells of a map."""
SIDE_PX = 220.0
LEFT_PX, BOTTOM_PX = 46.0, 34.0


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Size of the mean mismatch in each cell, shape (cells, cells), NaN where it is not known.

    noise: up to this size a cell's mismatch is no more than noise does, shape (cells, cells).
    passed: cells with so few readings around them that they say nothing.
    """

    across: FloatArray
    up: FloatArray
    before: FloatArray
    after: FloatArray
    noise: FloatArray
    passed: BoolArray


def place_maps(covariates: Mapping[str, FloatArray], channels: Sequence[Mismatch]) -> str:
    """From above and from the side, as HTML; empty where the positions are not known."""
    bare = {words.bare(name): values for name, values in covariates.items()}
    place = {axis: bare.get(f"range_{axis}", bare.get(f"pos_{axis}")) for axis in "xyz"}
    unchanged = all(one.unchanged for one in channels)
    # What is much smaller than the noise shall not look loud.
    loudest = max([one.noise for one in channels if np.isfinite(one.noise)], default=0.0)
    least = QUIET_SIGMAS * loudest or 1e-3
    parts = []
    for title, across, up in (("from above", "x", "y"), ("from the side", "x", "z")):
        first, second = place[across], place[up]
        if first is None or second is None:
            continue
        grid = grid_of(first * 1e3, second * 1e3, channels)
        if grid is None:
            continue
        top = max(float(np.nanquantile(grid.before, TOP_SHARE)), least)
        maps = ((", before", grid.before), (", after", grid.after))
        for when, values in (("", grid.before),) if unchanged else maps:
            caption = f"{title.capitalize()}{when}"
            parts.append(_map(caption, grid, values, top, f"{across} [mm]", f"{up} [mm]"))
    if not parts:
        return ""
    about = (
        "How far measured and predicted are apart on average at each place, beyond what noise "
        "does to an average of so few readings. The redder, the further apart; grey cells differ "
        "by no more than noise does. Cells are larger where readings are few."
    )
    return paragraph(about) + f'<div class="maps">{columns(parts)}</div>'


def grid_of(across: FloatArray, up: FloatArray, channels: Sequence[Mismatch]) -> Grid | None:
    """Size of the mean mismatch (over channels) in each cell; None without readings."""
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

    numbers: readings in each cell, shape (cells, cells). A cell with enough stands alone. Of the
    rest, those in a square of JOINED cells a side go together; the square is filled, unless a
    cell in it stands alone and so shows where the robot went.
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
) -> FloatArray:  # fmt: skip
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


def _quiet_squares(
    groups: IntArray, known: BoolArray, channels: Sequence[Mismatch]
) -> FloatArray:  # fmt: skip
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


def _map(caption: str, grid: Grid, values: FloatArray, top: float, x: str, y: str) -> str:
    quiet = values <= grid.noise
    paths = [_cells("passed", grid.passed), _cells("noise", quiet)]
    for level in range(LEVELS):
        low, high = level / LEVELS * top, (level + 1) / LEVELS * top
        last = level == LEVELS - 1
        here = (values >= low) & ((values < high) | last)
        paths.append(_cells(f"level{level}", here & ~quiet))
    width, height = LEFT_PX + SIDE_PX + 6.0, SIDE_PX + BOTTOM_PX
    frame = f'<rect class="frame" x="{LEFT_PX}" y="0" width="{SIDE_PX}" height="{SIDE_PX}"/>'
    return (
        f'<figure class="map"><figcaption>{caption}</figcaption>'
        f'<svg viewBox="0 -2 {width:.0f} {height + 2:.0f}" role="img" aria-label="{caption}">'
        f"{frame}{''.join(paths)}{_axes(grid, x, y)}</svg>"
        f"{_key(top, bool(quiet.any()), bool(grid.passed.any()))}</figure>"
    )


def _cells(kind: str, chosen: BoolArray) -> str:
    """The chosen cells, painted a little larger, so that no gap shows between them."""
    size = SIDE_PX / CELLS
    rows, cols = np.nonzero(chosen)
    cells = "".join(
        f"M{LEFT_PX + col * size:.1f} {SIDE_PX - (row + 1) * size:.1f}"
        f"h{size + 0.3:.1f}v{size + 0.3:.1f}h-{size + 0.3:.1f}z"
        for row, col in zip(rows.tolist(), cols.tolist(), strict=True)
    )
    return f'<path class="{kind}" d="{cells}"/>' if cells else ""


def _axes(grid: Grid, x: str, y: str) -> str:
    def word(at: tuple[float, float], anchor: str, text: str) -> str:
        return f'<text x="{at[0]:.0f}" y="{at[1]:.0f}" text-anchor="{anchor}">{text}</text>'

    def end(value: float) -> str:
        return number(value, 0)

    below, left, right = SIDE_PX + 14.0, LEFT_PX, LEFT_PX + SIDE_PX
    return (
        word((left, below), "start", end(float(grid.across[0])))
        + word((right, below), "end", end(float(grid.across[-1])))
        + word((0.5 * (left + right), below + 4.0), "middle", x)
        + word((left - 4.0, SIDE_PX), "end", end(float(grid.up[0])))
        + word((left - 4.0, 12.0), "end", end(float(grid.up[-1])))
        + word((left - 4.0, 0.5 * SIDE_PX), "end", y)
    )


def _key(top: float, quiet: bool, passed: bool) -> str:
    swatches = "".join(f'<i class="level{level}"></i>' for level in range(LEVELS))
    upper = number(top, max(0, significant(top, 2)))
    noise = ' <i class="noise"></i> no more than noise' if quiet else ""
    few = ' <i class="passed"></i> too few readings to say' if passed else ""
    return f'<p class="note ramp">0 {swatches} {upper} mm and more{noise}{few}</p>'
