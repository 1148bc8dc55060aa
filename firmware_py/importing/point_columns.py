"""The columns of a table of points, by their headings (`X (mm)`, `z_m`, `F`), and one more row."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from deltactl.firmware_py.importing.drawn import TABLES, Point
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.recording.tables.csv_table import read_text
from deltactl.recording.tables.table_format import SEPARATORS, TableFormat, guess_format, split

LENGTHS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "um": 1e-6, "in": 0.0254, "inch": 0.0254}
SPEEDS = {
    **dict.fromkeys(("mm/s", "mmps"), 1e-3),
    **dict.fromkeys(("m/s", "mps"), 1.0),
    **dict.fromkeys(("mm/min", "mmpm"), 1e-3 / 60.0),
    "m/min": 1.0 / 60.0,
}
TIMES = {"s": 1.0, "sec": 1.0, "ms": 1e-3}
UNITS = {"x": LENGTHS, "y": LENGTHS, "z": LENGTHS, "speed": SPEEDS, "dwell": TIMES}
"""Factor to metres, m/s and seconds."""
NAMES: dict[str, tuple[str, str]] = {
    **{axis: (axis, "mm") for axis in "xyz"},
    **dict.fromkeys(("speed", "feed", "v"), ("speed", "mm/s")),
    **dict.fromkeys(("f", "feedrate"), ("speed", "mm/min")),
    **dict.fromkeys(("dwell", "wait", "pause"), ("dwell", "s")),
}
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
        if heading not in skip:
            yield from _wrong_heading(heading, unit, seen)
    if missing := [name for name in "xy" if name not in seen]:
        yield f"has no column {', '.join(missing)}; it has {', '.join(headings)}"
    for heading in skip:
        if heading not in headings:
            yield f'--skip "{heading}": is no column of it; it has {", ".join(headings)}'


def _wrong_heading(heading: str, unit: str, seen: dict[str, str]) -> Iterator[str]:
    """seen: quantity -> heading, of those before it; this one is added."""
    said = _HEADING.fullmatch(heading.strip().lower())
    if said is None or said[1] not in NAMES:
        yield (
            f"'{heading}' is no column of a point ({', '.join(NAMES)}); correct it, or leave it"
            f' out with --skip "{heading}"'
        )
        return
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


def headings_of(form: TableFormat) -> tuple[str, ...]:
    """What the columns of a table are called, here where it does not say it itself."""
    if form.named:
        return form.names
    return (*UNNAMED, *form.names[len(UNNAMED) :])[: len(form.names)]


HEADING = "x_mm,y_mm,z_mm,dwell_s\n"
DIGITS = 9
"""Digits of a coordinate in metres; enough in any unit."""


def add_point(path: Path, place_m: Point, dwell_s: float) -> None:
    """One more row; a new table gets a heading. Raises ConfigError where the file is no table."""
    if path.suffix.lower() not in TABLES:
        raise ConfigError(f"{path}: teach adds to a table of points; name one that ends in .csv")
    text = read_text(path, any_encoding=True) if path.exists() else ""
    if not text.strip():
        text = HEADING
    separator, decimal, names, columns = _form(path, text)
    if dwell_s and "dwell" not in {column.kind for column in columns.values()}:
        raise ConfigError(
            f"{path}: has no column for --dwell; add one called dwell_s, or leave --dwell out"
        )
    values = dict(zip("xyz", place_m, strict=True)) | {"dwell": dwell_s}
    cells = (_cell(columns.get(name), values, decimal) for name in names)
    row = ("\t" if separator == " " else separator).join(cells)
    write_whole(path, f"{text}{'' if text.endswith(chr(10)) else chr(10)}{row}\n")


def _form(path: Path, text: str) -> tuple[str, str, tuple[str, ...], dict[str, Column]]:
    """Separator, decimal mark, headings, and what is known of them."""
    lines = [line for line in text.split("\n") if line.strip()]
    if len(lines) == 1:  # a heading alone
        for separator in SEPARATORS:
            names = tuple(split(lines[0], separator))
            columns = columns_of(names, ("",) * len(names))
            if _has_places(columns):
                return separator, ".", names, columns
    try:
        form = guess_format(path)
    except RecordingError:
        raise _no_table(path) from None
    names = headings_of(form)
    columns = columns_of(names, form.units)
    if not _has_places(columns):
        raise _no_table(path)
    return form.separator, form.decimal, names, columns


def _has_places(columns: dict[str, Column]) -> bool:
    return {"x", "y", "z"} <= {column.kind for column in columns.values()}


def _cell(column: Column | None, values: dict[str, float], decimal: str) -> str:
    if column is None or column.kind not in values:
        return ""
    value = round(values[column.kind], DIGITS) / column.scale
    return f"{value:z.7g}".replace(".", decimal)


def _no_table(path: Path) -> ConfigError:
    return ConfigError(
        f"{path}: is no table of points with columns x, y and z; name another file (a new one is"
        " made), or give it these columns"
    )
