"""Adding a point to a table of points, in the columns that it has."""

from __future__ import annotations

from pathlib import Path

from deltactl.firmware_py.importing.drawn import TABLES, Point
from deltactl.firmware_py.importing.point_columns import Column, columns_of
from deltactl.firmware_py.importing.points_table import headings_of
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.recording.tables.csv_table import read_text
from deltactl.recording.tables.table_format import SEPARATORS, guess_format, split

HEADING = "x_mm,y_mm,z_mm,dwell_s\n"
DIGITS = 9
"""Of a coordinate in metres; as many as matter, in any unit."""


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
