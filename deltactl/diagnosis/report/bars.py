"""Small drawings of HTML and SVG: intervals on a line, bars before and after, maps of cells."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from deltactl.charts.cells import CELLS, Grid
from deltactl.charts.means import BoolArray
from deltactl.charts.spec import FloatArray
from deltactl.diagnosis.report.sizes import Size, number, significant
from deltactl.diagnosis.report.templates import say

NEAR = 16.0
"""Labels closer than this [% of the line] would run into each other."""
LEVELS = 6
SIDE_PX, LEFT_PX, BOTTOM_PX = 220.0, 46.0, 34.0


@dataclass(frozen=True, slots=True)
class Pair:
    """Two bars of one thing: before and after the findings (NaN: there are none)."""

    name: str
    before: float
    after: float


def interval_bar(size: Size, nothing: float = 0.0, smallest: float = math.nan) -> str:
    """The interval against 'nothing wrong' and the detection limit."""
    ends = [size.value, size.low, size.high, nothing]
    known = [x for x in ends if math.isfinite(x)]
    if not math.isfinite(size.value):
        return ""
    if math.isfinite(smallest) and abs(smallest) < 3.0 * max(abs(x) for x in known):
        smallest = math.copysign(smallest, size.value)
        known.append(smallest)
    else:
        smallest = math.nan
    low, high = min(known), max(known)
    room = 0.06 * (high - low) or max(abs(high), 1.0)
    low, high = low - room, high + room

    def place(value: float) -> float:
        return min(100.0, max(0.0, 100.0 * (value - low) / (high - low)))

    left = place(size.low) if math.isfinite(size.low) else place(size.value)
    right = place(size.high) if math.isfinite(size.high) else place(size.value)
    parts = ['<i class="track"></i>', _at("tick", place(nothing))]
    if math.isfinite(smallest):
        parts.append(_at("tick faint", place(smallest)))
    parts.append(f'<i class="range" style="left:{left:.2f}%;width:{right - left:.2f}%"></i>')
    parts.append(_at("dot", place(size.value)))
    parts += _labels(size, place(nothing), nothing, place(smallest) if known else 0.0, smallest)
    says = html.escape(f"{size.name}: {size.text}", quote=True)
    return f'<div class="interval" role="img" aria-label="{says}">{"".join(parts)}</div>'


def _labels(
    size: Size, zero: float, nothing: float, faint: float, smallest: float
) -> Iterable[str]:
    yield _word(
        zero, say("bar.nothing_wrong") if nothing == 0.0 else number(nothing, significant(nothing))
    )
    if math.isfinite(smallest):
        yield _word(faint, say("bar.smallest_visible"), low=abs(faint - zero) < 2.0 * NEAR)


def _at(kind: str, place: float) -> str:
    return f'<i class="{kind}" style="left:{place:.2f}%"></i>'


def _word(place: float, text: str, low: bool = False) -> str:
    side = "start" if place < NEAR else "end" if place > 100.0 - NEAR else ""
    side += " low" if low else ""
    return f'<span class="{side}" style="left:{place:.2f}%">{html.escape(text)}</span>'


def pair_bars(title: str, pairs: Iterable[Pair], noise: float, unit: str, note: str = "") -> str:
    """Bars before and after, with the noise floor as a line through all of them."""
    pairs = list(pairs)
    values = [x for pair in pairs for x in (pair.before, pair.after)] + [noise]
    top = max([x for x in values if math.isfinite(x)], default=1.0) or 1.0
    least = min([x for x in values[:-1] if math.isfinite(x) and x > 0.0], default=top)
    digits = max(0, significant(top, 3), significant(least, 2))
    rows = "".join(_pair(pair, noise, top, unit, digits) for pair in pairs)
    key = f'<span class="was">{say("bar.robot_file")}</span>'
    if any(math.isfinite(pair.after) for pair in pairs):
        key += f'<span class="became">{say("bar.with_findings")}</span>'
    key += f'<span class="noise">{say("bar.noise_floor")}</span>' if math.isfinite(noise) else ""
    caption = f"<figcaption>{html.escape(title)}</figcaption>" if title else ""
    foot = f'<p class="note">{html.escape(note)}</p>' if note else ""
    return f'<figure class="pairs">{caption}<p class="key note">{key}</p>{rows}{foot}</figure>'


def _pair(pair: Pair, noise: float, top: float, unit: str, digits: int) -> str:
    def width(value: float) -> float:
        return 100.0 * min(max(value, 0.0) / top, 1.0) if math.isfinite(value) else 0.0

    after = f" \u2192 {number(pair.after, digits)}" if math.isfinite(pair.after) else ""
    text = f"{number(pair.before, digits)}{after} {unit}"
    line = f'<b style="left:{width(noise):.2f}%"></b>' if math.isfinite(noise) else ""
    return (
        f'<div class="pair"><span>{html.escape(pair.name)}</span><div>'
        f'<i class="was" style="width:{width(pair.before):.2f}%"></i>'
        f'<i class="became" style="width:{width(pair.after):.2f}%"></i>{line}</div>'
        f"<span>{html.escape(text)}</span></div>"
    )


def cell_map(
    caption: str, grid: Grid, values: FloatArray, top: float, labels: tuple[str, str]
) -> str:
    """A map of a grid's values, with its key; top: where the darkest colour begins."""
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
        f"{frame}{''.join(paths)}{_axes(grid, *labels)}</svg>"
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
    noise = f' <i class="noise"></i> {say("map.quiet")}' if quiet else ""
    few = f' <i class="passed"></i> {say("map.passed")}' if passed else ""
    most = say("map.most", top=upper)
    return f'<p class="note ramp">0 {swatches} {most}{noise}{few}</p>'
