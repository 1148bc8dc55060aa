"""A table of points: x, y, z, and where wanted a speed and a dwell, in the units of its heading."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.firmware_py.importing.drawn import FLAT, Drawn, Point
from deltactl.firmware_py.importing.point_columns import UNNAMED, Column, columns_of
from deltactl.foundation.errors import ConfigError
from deltactl.models.robot import FloatArray
from deltactl.recording.tables.foreign_table import read_table
from deltactl.recording.tables.table_format import TableFormat, guess_format

SAME_M = 1e-6


def read_points(
    path: Path, origin_m: Point, spline: bool = False, skip: Collection[str] = ()
) -> Drawn:
    """A CSV of points as legs; without a heading its columns are x, y, z (mm), speed, dwell.

    spline: on a smooth curve through them; points that repeat the one before are left out then.

    Raises RecordingError, or ConfigError naming what is missing.
    """
    form = guess_format(path)
    names = headings_of(form)
    columns = columns_of(names, form.units)
    kinds = {column.kind: name for name, column in columns.items()}
    missing = [name for name in "xy" if name not in kinds]
    if missing:
        raise ConfigError(f"{path}: has no column {', '.join(missing)}; it has {', '.join(names)}")
    table, lines = _table(path, form, names, columns)
    places = np.stack([table.get(axis, np.zeros(len(table["x"]))) for axis in "xyz"], axis=1)
    places = places + np.array(origin_m)
    bad = np.argwhere(~np.isfinite(places))
    if len(bad):
        row, axis = bad[0]
        raise ConfigError(
            f"{path}:{lines[row]}: {kinds['xyz'[axis]]} is empty; a point needs every coordinate:"
            " complete or delete the row"
        )
    if len(places) < 2:
        raise ConfigError(f"{path}: holds {len(places)} point(s); a path needs two")
    legs = [(row, _leg(places[row], table, row)) for row in range(1, len(places))]
    if spline:
        moved = np.linalg.norm(np.diff(places, axis=0), axis=1) > SAME_M
        legs = [(row, leg | {"spline": True}) for (row, leg), far in zip(legs, moved, strict=True)
                if far]  # fmt: skip
    first = _leg(places[0], table, 0)
    if "dwell_s" in first:  # the platform waits at the first point, before it sets out
        legs.insert(0, (0, {"to_m": first["to_m"], "dwell_s": first["dwell_s"]}))
    notes = [f"column '{name}' passed over" for name in names if name not in columns]
    notes += [FLAT] if "z" not in kinds else []
    notes += ["the first point's speed passed over: no move leads to it"] * ("speed_mps" in first)
    return Drawn(
        first["to_m"],
        tuple(leg for _, leg in legs),
        (*_units_read(columns), *notes),
        tuple(lines[row] for row, _ in legs),
        lines[0],
    )


def headings_of(form: TableFormat) -> tuple[str, ...]:
    """What the columns of a table are called, here where it does not say it itself."""
    if form.named:
        return form.names
    return (*UNNAMED, *form.names[len(UNNAMED) :])[: len(form.names)]


def _table(
    path: Path, form: TableFormat, names: tuple[str, ...], columns: dict[str, Column]
) -> tuple[dict[str, FloatArray], list[int]]:
    """Columns by what they are, in m, m/s and s, and the line of each row in the file."""
    heading = () if form.heading_line is not None else names
    skip = form.first_row if heading else form.heading_line or 0
    lines: list[int] = []
    table = read_table(
        path, skip, heading, form.separator, form.decimal, tuple(columns), lines_of=lines
    )
    return {column.kind: table[name] * column.scale for name, column in columns.items()}, lines


def _units_read(columns: dict[str, Column]) -> list[str]:
    """Units that are not the usual ones, so that a wrong heading shows."""
    usual = ("mm", "mm/s", "mmps", "s")
    return [
        f"column '{name}' read in {column.unit}"
        for name, column in columns.items()
        if column.unit not in usual
    ]


def _leg(place: Any, table: dict[str, FloatArray], row: int) -> dict[str, Any]:
    leg: dict[str, Any] = {"to_m": tuple(round(float(value), 9) for value in place)}
    for key, name in (("speed_mps", "speed"), ("dwell_s", "dwell")):
        values = table.get(name)
        if values is not None and np.isfinite(values[row]) and values[row] > 0.0:
            leg[key] = float(f"{values[row]:.6g}")
    return leg
