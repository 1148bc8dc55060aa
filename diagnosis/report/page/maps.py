"""Maps of the workspace: how large the mismatch is at each place, before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from charts.page import columns, paragraph
from diagnosis.answer.records import FloatArray
from diagnosis.report.page.residuals import BoolArray, Mismatch
from diagnosis.report.sentences import words
from diagnosis.report.sentences.sizes import number, significant

CELLS = 24
FEWEST = 4
"""Readings a cell needs."""
LEVELS = 6
TOP_SHARE = 0.98
"""The darkest colour starts at this quantile of the cells before; one wild cell does not rule."""
QUIET_SIGMAS = 2.0
"""The darkest colour stands for at least so many standard deviations of a reading."""
SIDE_PX = 220.0
LEFT_PX, BOTTOM_PX = 46.0, 34.0


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Size of the mean mismatch in each cell, shape (cells, cells), NaN where nobody was."""

    across: FloatArray
    up: FloatArray
    before: FloatArray
    after: FloatArray


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
        "does to an average of so few readings. The redder, the further apart."
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
    squares = [_squares(flat, known, channels, when) for when in ("before", "after")]
    if not np.isfinite(squares[0]).any():
        return None
    before, after = (np.sqrt(square).reshape(CELLS, CELLS) for square in squares)
    return Grid(edges[0], edges[1], before, after)


def _squares(
    flat: Any, known: BoolArray, channels: Sequence[Mismatch], when: str
) -> FloatArray:  # fmt: skip
    """Sum over channels of the squared mean of each cell, less what noise adds to it."""
    total = np.zeros(CELLS * CELLS)
    seen = np.zeros(CELLS * CELLS, dtype=np.bool_)
    for one in channels:
        values: FloatArray = getattr(one, when)
        good = known & np.isfinite(values)
        numbers = np.bincount(flat[good], minlength=CELLS * CELLS)
        sums = np.bincount(flat[good], weights=values[good], minlength=CELLS * CELLS)
        enough = numbers >= FEWEST
        total[enough] += (sums[enough] / numbers[enough]) ** 2 - one.spread**2 / numbers[enough]
        seen |= enough
    squares: FloatArray = np.where(seen, np.maximum(total, 0.0), np.nan)
    return squares


def _map(caption: str, grid: Grid, values: FloatArray, top: float, x: str, y: str) -> str:
    size = SIDE_PX / CELLS
    paths = []
    for level in range(LEVELS):
        low, high = level / LEVELS * top, (level + 1) / LEVELS * top
        last = level == LEVELS - 1
        rows, cols = np.nonzero((values >= low) & ((values < high) | last))
        # Painted a little larger, so that no gap shows between cells.
        cells = "".join(
            f"M{LEFT_PX + col * size:.1f} {SIDE_PX - (row + 1) * size:.1f}"
            f"h{size + 0.3:.1f}v{size + 0.3:.1f}h-{size + 0.3:.1f}z"
            for row, col in zip(rows.tolist(), cols.tolist(), strict=True)
        )
        if cells:
            paths.append(f'<path class="level{level}" d="{cells}"/>')
    width, height = LEFT_PX + SIDE_PX + 6.0, SIDE_PX + BOTTOM_PX
    frame = f'<rect class="frame" x="{LEFT_PX}" y="0" width="{SIDE_PX}" height="{SIDE_PX}"/>'
    return (
        f'<figure class="map"><figcaption>{caption}</figcaption>'
        f'<svg viewBox="0 -2 {width:.0f} {height + 2:.0f}" role="img" aria-label="{caption}">'
        f"{frame}{''.join(paths)}{_axes(grid, x, y)}</svg>{_key(top)}</figure>"
    )


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


def _key(top: float) -> str:
    swatches = "".join(f'<i class="level{level}"></i>' for level in range(LEVELS))
    upper = number(top, max(0, significant(top, 2)))
    return f'<p class="note ramp">0 {swatches} {upper} mm and more</p>'
