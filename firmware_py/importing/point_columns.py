"""What the columns of a table of points are, by their headings: `x`, `X (mm)`, `z_m`, `F`."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass

LENGTHS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "um": 1e-6, "in": 0.0254, "inch": 0.0254}
SPEEDS = {
    "mm/s": 1e-3, "mmps": 1e-3, "m/s": 1.0, "mps": 1.0, "mm/min": 1e-3 / 60.0,
    "mmpm": 1e-3 / 60.0, "m/min": 1.0 / 60.0,
}  # fmt: skip
TIMES = {"s": 1.0, "sec": 1.0, "ms": 1e-3}
UNITS = {"x": LENGTHS, "y": LENGTHS, "z": LENGTHS, "speed": SPEEDS, "dwell": TIMES}
"""Factor to metres, m/s and seconds."""
NAMES: dict[str, tuple[str, str]] = {
    "x": ("x", "mm"), "y": ("y", "mm"), "z": ("z", "mm"),
    "speed": ("speed", "mm/s"), "feed": ("speed", "mm/s"), "v": ("speed", "mm/s"),
    "f": ("speed", "mm/min"), "feedrate": ("speed", "mm/min"),
    "dwell": ("dwell", "s"), "wait": ("dwell", "s"), "pause": ("dwell", "s"),
}  # fmt: skip
"""Plain names, what they are, and the unit where none is said: F is that of G-code."""
UNNAMED = ("x", "y", "z", "speed", "dwell")
"""The order of columns in a table without a heading."""
_HEADING = re.compile(r"([a-z]+)[\s_]*[\[(]?\s*([a-z]+(?:/[a-z]+)?)?\s*[\])]?")


@dataclass(frozen=True, slots=True)
class Column:
    """One column: x, y, z, speed or dwell, its unit, and the factor to m, m/s or s."""

    kind: str
    unit: str
    scale: float


def column_of(heading: str, unit: str = "") -> Column | None:
    """The column of a heading; None where it is none of a point. unit: of a line below it."""
    said = _HEADING.fullmatch(heading.strip().lower())
    if said is None or said[1] not in NAMES:
        return None
    kind, usual = NAMES[said[1]]
    given = (said[2] or unit.strip("[]() ").lower()) or usual
    scale = UNITS[kind].get(given)
    return None if scale is None else Column(kind, given, scale)


def columns_of(headings: tuple[str, ...], units: tuple[str, ...]) -> dict[str, Column]:
    """Those that are known, by their heading; of two of a kind the first."""
    found: dict[str, Column] = {}
    for heading, unit in zip(headings, units, strict=True):
        column = column_of(heading, unit)
        if column is not None and column.kind not in {one.kind for one in found.values()}:
            found[heading] = column
    return found


def wrong_headings(
    headings: tuple[str, ...], units: tuple[str, ...], skip: Collection[str]
) -> Iterator[str]:
    """What cannot be taken as it says; skip: headings that are left out."""
    seen: dict[str, str] = {}
    for heading, unit in zip(headings, units, strict=True):
        if heading in skip:
            continue
        said = _HEADING.fullmatch(heading.strip().lower())
        if said is None or said[1] not in NAMES:
            yield (
                f"'{heading}' is no column of a point ({', '.join(NAMES)}); correct it, or leave it"
                f' out with --skip "{heading}"'
            )
            continue
        kind = NAMES[said[1]][0]
        below = unit.strip("[]() ").lower()
        given = said[2] or below
        if given and given not in UNITS[kind]:
            yield f"'{heading}' is in {given}; units of {kind} are {', '.join(UNITS[kind])}"
        elif said[2] and below and said[2] != below:
            yield f"'{heading}' is in {said[2]}, and in {below} in the line below; correct one"
        if kind in seen:
            yield f"'{seen[kind]}' and '{heading}' both give {kind}; delete one of these columns"
        seen.setdefault(kind, heading)
    if missing := [name for name in "xy" if name not in seen]:
        yield f"has no column {', '.join(missing)}; it has {', '.join(headings)}"
    for heading in skip:
        if heading not in headings:
            yield f'--skip "{heading}": is no column of it; it has {", ".join(headings)}'
