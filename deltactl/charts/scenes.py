"""A machine as a drawing in SVG: named parts, with numbered marks on top."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot

Point = tuple[float, float]
"""On paper: x to the right, y down."""

BADGE_RADIUS = 10.0
MOST_BADGES = 3
MARGIN = 14.0
LEAST_WIDTH = 320.0
LABEL_HEIGHT = 14.0
LETTER_WIDTH = 7.4


@dataclass(frozen=True, slots=True)
class Mark:
    """A finding at a part: its number and its colour; `maybe` where it is only an alternative."""

    number: int
    maybe: bool = False


@dataclass(frozen=True, slots=True)
class Label:
    """A word beside a part; anchor as in SVG: start, middle or end."""

    text: str
    at: Point
    anchor: str = "middle"


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the machine: SVG shapes, where its badge goes, and how far off it is."""

    name: str
    shapes: tuple[str, ...]
    corners: tuple[Point, ...]
    badge: Point
    depth: float = 0.0
    """Larger is nearer to the eye and painted later."""
    style: str = "solid"
    """solid, line or beam."""


@dataclass(slots=True)
class Scene:
    """Parts and labels of one drawing."""

    title: str
    parts: list[Part] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)

    def svg(self, marks: Mapping[str, Sequence[Mark]]) -> str:
        """The drawing; `marks` says which findings touch which part."""
        ordered = sorted(self.parts, key=lambda part: part.depth)
        body = "".join(_part(part, marks.get(part.name, ())) for part in ordered)
        words = "".join(_label(label) for label in self.labels)
        badges = "".join(_badge(at, number) for at, number in badge_places(self.parts, marks))
        left, top, width, height = self._box(marks)
        title = html.escape(self.title, quote=True)
        return (
            f'<svg class="machine" viewBox="{left:.0f} {top:.0f} {width:.0f} {height:.0f}" '
            f'role="img" aria-label="{title}"><title>{title}</title>{body}{words}{badges}</svg>'
        )

    def _box(self, marks: Mapping[str, Sequence[Mark]]) -> tuple[float, float, float, float]:
        xs = [x for part in self.parts for x, _ in part.corners]
        ys = [y for part in self.parts for _, y in part.corners]
        for (x, y), _ in badge_places(self.parts, marks):
            xs += [x - BADGE_RADIUS, x + BADGE_RADIUS]
            ys += [y - BADGE_RADIUS, y + BADGE_RADIUS]
        for label in self.labels:
            x, y = label.at
            width = LETTER_WIDTH * len(label.text)
            start = x - width * {"start": 0.0, "middle": 0.5, "end": 1.0}[label.anchor]
            xs += [start, start + width]
            ys += [y - LABEL_HEIGHT, y + 4.0]
        # A narrow machine is not blown up: letters would grow with it.
        short = max(0.0, LEAST_WIDTH - (max(xs) - min(xs))) / 2.0
        left, top = min(xs) - MARGIN - short, min(ys) - MARGIN
        return left, top, max(xs) - left + MARGIN + short, max(ys) - top + MARGIN


def polygon(points: Iterable[Point]) -> str:
    """A filled outline."""
    return f'<polygon points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}"/>'


def line(start: Point, end: Point) -> str:
    """A stroke."""
    return f'<path d="M{start[0]:.1f} {start[1]:.1f}L{end[0]:.1f} {end[1]:.1f}"/>'


def circle(centre: Point, radius: float) -> str:
    """A disc."""
    return f'<circle cx="{centre[0]:.1f}" cy="{centre[1]:.1f}" r="{radius:.1f}"/>'


def rod(start: Point, end: Point, half: float) -> list[Point]:
    """Corners of a bar of half width `half` from start to end."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = max((dx * dx + dy * dy) ** 0.5, 1e-9)
    nx, ny = -dy / length * half, dx / length * half
    return [
        (start[0] + nx, start[1] + ny),
        (end[0] + nx, end[1] + ny),
        (end[0] - nx, end[1] - ny),
        (start[0] - nx, start[1] - ny),
    ]


def hull(points: Iterable[Point]) -> list[Point]:
    """Corners of the tightest convex outline (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    if len(ordered) <= 2:
        return ordered

    def half(run: Iterable[Point]) -> list[Point]:
        kept: list[Point] = []
        for x, y in run:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    return half(ordered) + half(reversed(ordered))


def box(left: float, top: float, width: float, height: float) -> list[Point]:
    """Corners of an upright rectangle."""
    right, bottom = left + width, top + height
    return [(left, top), (right, top), (right, bottom), (left, bottom)]


def hue(number: int) -> int:
    """Which of the five colours finding `number` (from 1) has."""
    return (number - 1) % 5 + 1


def badge(number: int) -> str:
    """The number of a finding in its colour, for text."""
    return f'<span class="tag hue{hue(number)}">{number}</span>'


def _part(part: Part, marks: Sequence[Mark]) -> str:
    sure = [mark for mark in marks if not mark.maybe]
    chosen = (sure or list(marks))[:1]
    kinds = "".join(f" {'maybe' if m.maybe else 'hit'} hue{hue(m.number)}" for m in chosen)
    name = html.escape(part.name, quote=True)
    return f'<g class="part {part.style}{kinds}" data-part="{name}">{"".join(part.shapes)}</g>'


def _label(label: Label) -> str:
    x, y = label.at
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{label.anchor}">'
        f"{html.escape(label.text)}</text>"
    )


def badge_places(
    parts: Sequence[Part], marks: Mapping[str, Sequence[Mark]]
) -> list[tuple[Point, int]]:
    """Where the number of which finding goes: at its part, or beside what is there already."""
    places: list[tuple[Point, int]] = []
    for part in parts:
        sure = [mark for mark in marks.get(part.name, ()) if not mark.maybe]
        for mark in sure[:MOST_BADGES]:
            places.append((_free(part.badge, [at for at, _ in places]), mark.number))
    return places


def _free(wanted: Point, taken: Sequence[Point]) -> Point:
    """The place nearest to the one wanted, on a grid around it, where no other badge is."""
    step = 2.2 * BADGE_RADIUS
    reach = range(-len(taken), len(taken) + 1)
    ways = sorted(((i, j) for i in reach for j in reach), key=lambda way: (hypot(*way), -way[0]))
    places = [(wanted[0] + step * i, wanted[1] + step * j) for i, j in ways]
    return next(
        place
        for place in places
        if all(hypot(place[0] - x, place[1] - y) >= 2.1 * BADGE_RADIUS for x, y in taken)
    )


def _badge(at: Point, number: int) -> str:
    x, y = at
    return (
        f'<g class="badge hue{hue(number)}">{circle(at, BADGE_RADIUS)}'
        f'<text x="{x:.1f}" y="{y + 4.5:.1f}" text-anchor="middle">{number}</text></g>'
    )
