"""A table of points: x, y, z, and where wanted a speed and a dwell, in the units of its heading.

What it says is taken as it says, or refused with its line: a cell that is no number, a column
nobody knows, a line that is neither heading nor row.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from deltactl.firmware_py.importing.drawn import FLAT, MOST_MISTAKES, Drawn, Point, as_written
from deltactl.firmware_py.importing.point_columns import (
    Column,
    columns_of,
    headings_of,
    wrong_headings,
)
from deltactl.firmware_py.paths.legs import MOST_LEGS, LegsGathered
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.recording.tables.cells import number
from deltactl.recording.tables.csv_table import read_text
from deltactl.recording.tables.foreign_table import COMMENTS
from deltactl.recording.tables.table_format import SEPARATORS, TableFormat, guess_format, split

SAME_M = 1e-6
FIRST_SPEED = "the first point's speed passed over: no move leads to it"
_SHOWN = 40


@dataclass(frozen=True, slots=True)
class _Row:
    """One point, and the line that it is on."""

    line: int
    place_m: Point
    speed_mps: float | None
    dwell_s: float | None


def read_points(
    path: Path, origin_m: Point, spline: bool = False, skip: Collection[str] = ()
) -> Drawn:
    """A CSV of points as legs; without a heading its columns are x, y, z (mm), speed, dwell.

    spline: on a smooth curve through them; points that repeat the one before are left out then.
    skip: headings of columns that are left out.

    Raises RecordingError, or ConfigError naming every line that cannot be taken.
    """
    form = _form(path)
    names = headings_of(form)
    lines = read_text(path, any_encoding=True).split("\n")
    heading = _heading_line(form, lines)
    wrong = [f"{path}:{heading}: {says}" for says in wrong_headings(names, form.units, skip)]
    if wrong:
        raise ConfigError(*wrong)
    taken = [one for one in names if one not in skip]
    units = [unit for name, unit in zip(names, form.units, strict=True) if name not in skip]
    columns = columns_of(tuple(taken), tuple(units))
    reader = _Rows(form, names, columns, origin_m)
    drawn = _drawn(reader.all(path, lines, heading), spline)
    if reader.wrong:
        raise ConfigError(*reader.wrong)
    if drawn is None:
        raise ConfigError(f"{path}: holds {reader.count} point(s); a path needs two")
    notes = [f"column '{name}' passed over" for name in names if name in skip]
    notes += [FLAT] if "z" not in {column.kind for column in columns.values()} else []
    return replace(drawn, notes=(*reader.notes, *_units_read(columns), *notes, *drawn.notes))


def _form(path: Path) -> TableFormat:
    """How the table is written; a row that lacks cells must not make it one of other marks."""
    form = guess_format(path)
    if _has_places(form):
        return form
    for separator in SEPARATORS:
        try:
            other = guess_format(path, separator)
        except RecordingError:
            continue
        if other.named and _has_places(other):
            return other
    return form


def _has_places(form: TableFormat) -> bool:
    columns = columns_of(headings_of(form), form.units)
    return {"x", "y"} <= {column.kind for column in columns.values()}


def _heading_line(form: TableFormat, lines: list[str]) -> int:
    """The line of the heading, from 1; without one, that of the first row."""
    if not form.named:
        return form.first_row + 1
    above = range(form.first_row - 1, -1, -1)
    return 1 + next((n for n in above if _cells(lines[n], form) == form.names), form.first_row)


def _cells(line: str, form: TableFormat) -> tuple[str, ...]:
    marks = "#% " if form.separator == "\t" else "#% \t"
    return tuple(split(line.lstrip(marks), form.separator))


class _Rows:
    """Reads rows, and gathers what is wrong with them."""

    def __init__(
        self,
        form: TableFormat,
        names: tuple[str, ...],
        columns: dict[str, Column],
        origin_m: Point,
    ):
        self.wrong: list[str] = []
        self.notes: list[str] = []
        self.count = 0
        """Points so far."""
        self._form, self._names, self._columns, self._origin = form, names, columns, origin_m

    def all(self, path: Path, lines: list[str], heading: int) -> Iterator[_Row]:
        """Every point of the table."""
        form = self._form
        for line, text in enumerate(lines, 1):
            if not text.strip():
                continue
            if line <= form.first_row:
                says = self._before(text, is_heading=form.named and line == heading)
                self.wrong += [f"{path}:{line}: {says}"] if says else []
                continue
            if len(self.wrong) >= MOST_MISTAKES:
                self.wrong.append(f"{path}: and more mistakes after these")
                return
            try:
                row = self._row(line, split(text, form.separator))
            except ValueError as error:
                self.wrong.append(f"{path}:{line}: {error}")
                continue
            self.count += 1
            if self.count > MOST_LEGS + 1:
                self.wrong.append(
                    f"{path}:{line}: a job has at most {MOST_LEGS + 1:,} points; split the table"
                )
                return
            yield row

    def _before(self, text: str, is_heading: bool) -> str:
        """What is wrong with a line above the first row; notes what is none of the table."""
        cells = _cells(text, self._form)
        if is_heading or (len(cells) == len(self._names) and cells == self._units_line(text)):
            return ""
        if not text.lstrip().startswith(COMMENTS) and any(
            number(cell, self._form.decimal) is not None for cell in cells
        ):
            return f"'{text.strip()[:_SHOWN]}' is no row as the others are; correct or delete it"
        self.notes.append(f"'{text.strip()[:_SHOWN]}' above the table passed over")
        return ""

    def _units_line(self, text: str) -> tuple[str, ...]:
        """The cells of a line, where they are the units below the heading."""
        cells = _cells(text, self._form)
        units = tuple(cell.strip("[]()") for cell in cells)
        return cells if any(units) and units == self._form.units else ()

    def _row(self, line: int, cells: list[str]) -> _Row:
        if len(cells) != len(self._names):
            raise ValueError(
                f"this row has {len(cells)} cells, the table has {len(self._names)} columns;"
                " complete or delete the row"
            )
        found: dict[str, float | None] = {}
        for name, cell in zip(self._names, cells, strict=True):
            column = self._columns.get(name)
            if column is not None:
                found[column.kind] = self._value(name, column, cell)
        x_m, y_m, z_m = as_written(
            tuple(
                round((found.get(axis) or 0.0) + zero, 9)
                for axis, zero in zip("xyz", self._origin, strict=True)
            )
        )
        return _Row(line, (x_m, y_m, z_m), found.get("speed"), found.get("dwell"))

    def _value(self, name: str, column: Column, cell: str) -> float | None:
        """The number of a cell in m, m/s or s; None where it is empty. Raises ValueError."""
        if not cell:
            if column.kind in "xyz":
                raise ValueError(
                    f"{name} is empty; a point needs every coordinate: complete or delete the row"
                )
            return None
        mixed = self._form.decimal == "," and "." in cell
        value = None if mixed else number(cell, self._form.decimal)
        if value is None or not math.isfinite(value):
            raise ValueError(f"{name} must be a number (got '{cell[:_SHOWN]}')")
        if column.kind == "speed" and value <= 0.0:
            raise ValueError(f"{name} must be above 0 (got '{cell}'), or empty for the job's")
        if column.kind == "dwell" and value < 0.0:
            raise ValueError(f"{name} must not be below 0 (got '{cell}')")
        scaled = value * column.scale
        return scaled if column.kind in "xyz" else float(f"{scaled:.6g}")


def _drawn(rows: Iterator[_Row], spline: bool) -> Drawn | None:
    """The path through all rows; None where they are no path."""
    first = next(rows, None)
    if first is None:
        return None
    legs, lines, last_m, points = LegsGathered(), array("L"), first.place_m, 1
    if first.dwell_s:  # the platform waits at the first point, before it sets out
        legs.add(first.place_m, dwell_s=first.dwell_s)
        lines.append(first.line)
    for points, row in enumerate(rows, 2):  # noqa: B007  the last of them is asked for below
        if not spline or math.dist(last_m, row.place_m) > SAME_M:
            legs.add(row.place_m, row.speed_mps, row.dwell_s or 0.0, spline=spline)
            lines.append(row.line)
        last_m = row.place_m
    notes = () if first.speed_mps is None else (FIRST_SPEED,)
    return None if points < 2 else Drawn(first.place_m, legs.legs(), notes, lines, first.line)


def _units_read(columns: dict[str, Column]) -> list[str]:
    """Units that are not the usual ones, so that a wrong heading shows."""
    usual = ("mm", "mm/s", "mmps", "s")
    return [
        f"column '{name}' read in {column.unit}"
        for name, column in columns.items()
        if column.unit not in usual
    ]
