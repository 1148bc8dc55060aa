"""Maps of cells as SVG: the size of the model error at each place, with a key of the colours."""

from __future__ import annotations

import math

import numpy as np

from deltactl.charts.cells import CELLS, Grid
from deltactl.charts.means import BoolArray
from deltactl.charts.spec import FloatArray

LEVELS = 6
SIDE_PX, LEFT_PX, BOTTOM_PX = 220.0, 46.0, 34.0
TOP_SHARE = 0.98
"""The darkest colour starts at this quantile of the cells; one wild cell does not rule."""
FROM_ZERO = 0.3
"""Colours begin at zero where the least of a map is less than this share of its most."""


def cell_map(
    caption: str,
    grid: Grid,
    values: FloatArray,
    darkest: float,
    labels: tuple[str, str],
) -> str:
    """A map of a grid's values, with its key; darkest: what the darkest colour means at least."""
    least, top = _colours(values[values > grid.noise], darkest)
    quiet = values <= grid.noise
    paths = [_cells("passed", grid.passed), _cells("noise", quiet)]
    for level in range(LEVELS):
        low, high = (least + k / LEVELS * (top - least) for k in (level, level + 1))
        first, last = level == 0, level == LEVELS - 1
        here = ((values >= low) | first) & ((values < high) | last)
        paths.append(_cells(f"level{level}", here & ~quiet))
    width, height = LEFT_PX + SIDE_PX + 6.0, SIDE_PX + BOTTOM_PX
    frame = f'<rect class="frame" x="{LEFT_PX}" y="0" width="{SIDE_PX}" height="{SIDE_PX}"/>'
    return (
        f'<figure class="map"><figcaption>{caption}</figcaption>'
        f'<svg viewBox="0 -2 {width:.0f} {height + 2:.0f}" role="img" aria-label="{caption}">'
        f"{frame}{''.join(paths)}{_axes(grid, *labels)}</svg>"
        f"{_key((least, top), bool(quiet.any()), bool(grid.passed.any()))}</figure>"
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
        return f"{round(value)}"

    below, left, right = SIDE_PX + 14.0, LEFT_PX, LEFT_PX + SIDE_PX
    return (
        word((left, below), "start", end(float(grid.across[0])))
        + word((right, below), "end", end(float(grid.across[-1])))
        + word((0.5 * (left + right), below + 4.0), "middle", x)
        + word((left - 4.0, SIDE_PX), "end", end(float(grid.up[0])))
        + word((left - 4.0, 12.0), "end", end(float(grid.up[-1])))
        + word((left - 4.0, 0.5 * SIDE_PX), "end", y)
    )


def _colours(shown: FloatArray, least: float) -> tuple[float, float]:
    """From where to where the colours of a map go: over the cells that it shows, so that places
    differ; from zero where some are next to nothing.

    least: what the darkest colour means at least.
    """
    if not len(shown):
        return 0.0, least
    low, top = (float(x) for x in np.quantile(shown, [1.0 - TOP_SHARE, TOP_SHARE]))
    top = max(top, least)
    return (low if low > FROM_ZERO * top else 0.0), top


def _key(ends: tuple[float, float], quiet: bool, passed: bool) -> str:
    swatches = "".join(f'<i class="level{level}"></i>' for level in range(LEVELS))
    decimals = max(0, 1 - math.floor(math.log10(ends[1]))) if ends[1] > 0.0 else 0
    lower, upper = (f"{end:.{decimals}f}" for end in ends)
    noise = ' <i class="noise"></i> no more than noise' if quiet else ""
    few = ' <i class="passed"></i> too few readings to say' if passed else ""
    least = f"{lower} mm and less" if ends[0] > 0.0 else "0"
    return f'<p class="note ramp">{least} {swatches} {upper} mm and more{noise}{few}</p>'
