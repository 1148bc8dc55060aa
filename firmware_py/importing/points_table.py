"""A table of points: x, y, z in mm, and where wanted speed in mm/s and a dwell in s."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from firmware_py.importing.drawn import Drawn, Point
from foundation.errors import ConfigError
from recording.tables.foreign_table import read_table
from recording.tables.table_format import guess_format

NAMES = {
    "x": ("x", "x_mm"), "y": ("y", "y_mm"), "z": ("z", "z_mm"),
    "speed": ("speed", "speed_mmps", "feed"), "dwell": ("dwell", "dwell_s", "wait"),
}  # fmt: skip

SAME_M = 1e-6


def read_points(path: Path, origin_m: Point, spline: bool = False) -> Drawn:
    """A CSV of points as legs; without a heading its columns are x, y, z (mm), speed, dwell.

    spline: on a smooth curve through them; points that repeat the one before are left out then.

    Raises RecordingError, or ConfigError naming what is missing.
    """
    form = guess_format(path)
    names = form.names if form.named else (*NAMES, *form.names[len(NAMES) :])[: len(form.names)]
    heading = () if form.heading_line is not None else names
    skip = form.first_row if heading else form.heading_line or 0
    known = {name for many in NAMES.values() for name in many}
    read = [name for name in names if name.strip().lower() in known]
    table = read_table(path, skip, heading, form.separator, form.decimal, read)
    plain = {name.strip().lower(): values for name, values in table.items()}
    columns: dict[str, Any] = {
        wanted: next((plain[name] for name in names if name in plain), None)
        for wanted, names in NAMES.items()
    }
    missing = [name for name in "xyz" if columns[name] is None]
    if missing:
        raise ConfigError(f"{path}: has no column {', '.join(missing)}; it has {', '.join(table)}")
    places = np.stack([columns[name] for name in "xyz"], axis=1) * 1e-3 + np.array(origin_m)
    bad = np.flatnonzero(~np.isfinite(places).all(axis=1))
    if len(bad):
        raise ConfigError(f"{path}: point {int(bad[0]) + 1} has an empty coordinate")
    if len(places) < 2:
        raise ConfigError(f"{path}: holds {len(places)} point(s); a path needs two")
    legs = [_leg(places[row], columns, row) for row in range(1, len(places))]
    if spline:
        moved = np.linalg.norm(np.diff(places, axis=0), axis=1) > SAME_M
        legs = [leg | {"spline": True} for leg, far in zip(legs, moved, strict=True) if far]
    start = places[0].tolist()
    return Drawn((start[0], start[1], start[2]), tuple(legs))


def _leg(place: Any, columns: dict[str, Any], row: int) -> dict[str, Any]:
    leg: dict[str, Any] = {"to_m": tuple(round(float(value), 9) for value in place)}
    for key, name, scale in (("speed_mps", "speed", 1e-3), ("dwell_s", "dwell", 1.0)):
        values = columns[name]
        if values is not None and np.isfinite(values[row]) and values[row] > 0.0:
            leg[key] = float(f"{values[row] * scale:.6g}")
    return leg
