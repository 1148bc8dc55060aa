"""The model error as a drawing that a notebook shows without scripts and without the network."""

from __future__ import annotations

import html
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from deltactl.charts.means import Mismatch, smoothed
from deltactl.charts.spec import FloatArray, keep
from deltactl.foundation.plain_file import said_of_output, write_whole

if TYPE_CHECKING:
    from deltactl.diagnosis.answer.records import Diagnosis
    from deltactl.interface.recordings import AnyPath

WIDTH, PANEL, GAP = 760.0, 130.0, 34.0
LEFT, RIGHT, TOP, BOTTOM = 64.0, 14.0, 46.0, 40.0
MOST_POINTS = 900
"""More than a panel has pixels; the peaks of all readings are kept."""
TICKS_ACROSS, TICKS_UP = 8, 3
INK, SOFT, LINE, READING, BEFORE, AFTER = (
    *("#1b2027", "#59626e", "#d9dde3", "#c9ced6"),
    *("#b3202c", "#1d6fc0"),
)
STEPS = (1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True)
class Figure:
    """A drawing; `svg` is its text."""

    svg: str

    @classmethod
    def of(cls, diagnosis: Diagnosis) -> Figure:
        """The model error over time, before and after the findings, a panel for each reading."""
        from deltactl.diagnosis.report.mismatch import drawn

        picture, channels = diagnosis.picture, drawn(diagnosis)
        if picture is None or not channels:
            return cls(_whole(60.0, ['<text x="20" y="34">There is nothing to draw.</text>']))
        height = TOP + BOTTOM + len(channels) * (PANEL + GAP) - GAP
        parts = list(_key())
        for number, one in enumerate(channels):
            last = number == len(channels) - 1
            parts += _panel(picture.t_s, one, TOP + number * (PANEL + GAP), last)
        return cls(_whole(height, parts))

    def save(self, path: AnyPath) -> None:
        """Write the SVG file. Raises RecordingError when it cannot be written."""
        with said_of_output(Path(path)):
            write_whole(Path(path), self.svg)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"Figure({len(self.svg)} characters of SVG)"


def ticks(low: float, high: float, most: int) -> list[float]:
    """Round numbers from low to high, at most `most` and about that many."""
    span = high - low
    if not span > 0.0:
        return [low]
    rough = span / most
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(size * power for size in STEPS if size * power >= rough * (1.0 - 1e-9))
    first = math.ceil(low / step - 1e-9)
    return [number * step for number in range(first, math.floor(high / step + 1e-9) + 1)]


def _whole(height: float, parts: Sequence[str]) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:.0f} {height:.0f}"'
        f' width="{WIDTH:.0f}" height="{height:.0f}" role="img" font-family="sans-serif"'
        f' font-size="12" fill="{SOFT}"><title>Model error before and after the findings</title>'
        f'<rect width="100%" height="100%" fill="#ffffff"/>{"".join(parts)}</svg>'
    )


def _key() -> Iterator[str]:
    """What the colours mean."""
    names = (("one reading", READING), ("robot file alone", BEFORE), ("with findings", AFTER))
    x = LEFT
    for name, colour in names:
        yield f'<path d="M{x:.0f} 12h18" stroke="{colour}" stroke-width="3"/>'
        yield f'<text x="{x + 24:.0f}" y="16">{name}</text>'
        x += 150.0


def _panel(t_s: FloatArray, one: Mismatch, top: float, last: bool) -> Iterator[str]:
    """Readings and their means over time; last: with times below."""
    start, end = float(np.nanmin(t_s)), float(np.nanmax(t_s))
    shown = np.concatenate([one.readings, one.after])
    shown = shown[np.isfinite(shown)]
    low, high = (float(shown.min()), float(shown.max())) if len(shown) else (-1.0, 1.0)
    low, high = min(low, 0.0), max(high, 0.0)
    high = high if high > low else low + 1.0

    def places(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        across = LEFT + (x - start) / max(end - start, 1e-12) * (WIDTH - LEFT - RIGHT)
        return across, top + PANEL - (y - low) / (high - low) * PANEL

    yield f'<text x="{LEFT:.0f}" y="{top - 5:.1f}" fill="{INK}">{html.escape(_title(one))}</text>'
    for value in ticks(low, high, TICKS_UP):
        _, y = places(np.zeros(1), np.array([value]))
        yield f'<path d="M{LEFT:.0f} {y[0]:.1f}H{WIDTH - RIGHT:.0f}" stroke="{LINE}"/>'
        yield f'<text x="{LEFT - 6:.0f}" y="{y[0] + 4:.1f}" text-anchor="end">{value:.4g}</text>'
    for value in ticks(start, end, TICKS_ACROSS) if last else ():
        x, _ = places(np.array([value]), np.zeros(1))
        yield f'<text x="{x[0]:.1f}" y="{top + PANEL + 16:.1f}" text-anchor="middle">{value:.6g}'
        yield "</text>"
    if last:
        middle = (LEFT + WIDTH - RIGHT) / 2
        yield f'<text x="{middle:.0f}" y="{top + PANEL + 33:.1f}" text-anchor="middle">time [s]'
        yield "</text>"
    curve = smoothed(t_s, one)
    for x, y, colour, width in (
        (t_s, one.readings, READING, 1.0),
        (curve.x, curve.before, BEFORE, 1.4),
        (curve.x, curve.after, AFTER, 1.4),
    ):
        yield _curve(*places(x, y), colour, width)


def _title(one: Mismatch) -> str:
    away = f"; {one.far_out} far out are left away" if one.far_out else ""
    return f"{one.name}: measured less predicted [{one.unit}]{away}"


def _curve(x: FloatArray, y: FloatArray, colour: str, width: float) -> str:
    """A line with a gap wherever there is no value."""
    kept = keep(x, y, MOST_POINTS)
    words, drawing = [], False
    for across, up in zip(x[kept].tolist(), y[kept].tolist(), strict=True):
        known = math.isfinite(across) and math.isfinite(up)
        if known:
            words.append(f"{'L' if drawing else 'M'}{across:.1f} {up:.1f}")
        drawing = known
    path = "".join(words)
    return f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width}"/>'
