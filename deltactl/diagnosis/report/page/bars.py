"""Small drawings of HTML alone: an interval on a line, and pairs of bars before and after."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable
from dataclasses import dataclass

from deltactl.diagnosis.report.phrases.sizes import Size, number, significant

NEAR = 16.0
"""Labels closer than this [% of the line] would run into each other."""


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
    yield _word(zero, "nothing wrong" if nothing == 0.0 else number(nothing, significant(nothing)))
    if math.isfinite(smallest):
        yield _word(faint, "smallest visible", low=abs(faint - zero) < 2.0 * NEAR)


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
    key = '<span class="was">robot file as it stands</span>'
    if any(math.isfinite(pair.after) for pair in pairs):
        key += '<span class="became">with the findings</span>'
    key += '<span class="noise">noise floor</span>' if math.isfinite(noise) else ""
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
