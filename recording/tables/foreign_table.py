"""Tables of others: any names, any separator, lines before the heading, or no heading at all."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path

import numpy as np

from foundation.errors import RecordingError
from recording.tables.cell import is_number, not_a_number, number, wrong_count
from recording.tables.flat import AnyArray
from recording.tables.left_out import without_remarks
from recording.tables.lerobot import files_of, is_data_set, names_of
from recording.tables.moment import is_date, is_moment, is_time_of_day, seconds
from recording.tables.parquet_and_mat import check_size, parquet_columns
from recording.tables.table_format import split
from recording.tables.text_file import read_text

_WITH_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")


def read_table(
    path: Path,
    skip_lines: int = 0,
    heading: Sequence[str] = (),
    separator: str = ",",
    decimal: str = ".",
    numbers: Collection[str] = (),
    tell: Callable[[str], None] = lambda _: None,
) -> dict[str, AnyArray]:
    """Columns of numbers by name, shape (n,) each; NaN where a cell holds no number.

    heading: names of the columns where the file has none. Dates and times of day are seconds since
    the first row's. numbers: columns in which every cell is to hold a number, or nothing. tell:
    takes words for comments and a footer that were left out, which happens where no column must
    hold numbers. Raises RecordingError.
    """
    lines = read_text(path, any_encoding=True).split("\n")[skip_lines:]
    if not heading:
        if not lines:
            raise RecordingError(f"{path}: has no line {skip_lines + 1} with a heading")
        heading = split(lines[0], separator)
        lines, skip_lines = lines[1:], skip_lines + 1
    rows = [
        (n, text, split(text, separator))
        for n, text in enumerate(lines, skip_lines + 1)
        if text.strip()
    ]
    if not numbers:
        rows, left_out = without_remarks(rows, len(heading), decimal)
        if left_out:
            tell(f"is read {left_out}")
    cells = [parts for _, _, parts in rows]
    if not cells:
        raise RecordingError(f"{path}: has a heading but no rows")
    for line, _, parts in rows:
        if len(parts) != len(heading):
            raise wrong_count(path, line, len(parts), len(heading))
        for name, cell in zip(heading, parts, strict=True):
            if name in numbers and not is_number(cell, decimal):
                raise not_a_number(path, line, name, cell)
    columns = list(zip(*cells, strict=True))
    for name, column in zip(heading, columns, strict=True):
        if decimal == "." and all(_WITH_COMMA.fullmatch(cell) for cell in column):
            raise RecordingError(
                f"{path}: {name} has a decimal comma ({column[0]}); add: --set decimal=,"
            )
    columns = _with_days(columns)
    return {name: _numbers(column, decimal) for name, column in zip(heading, columns, strict=True)}


def _with_days(columns: list[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """A day and a time of day in columns of their own are one time, in place of the second."""
    for place, (day, clock) in enumerate(itertools.pairwise(columns)):
        if is_date(day[0]) and is_time_of_day(clock[0]):
            whole = tuple(f"{d} {c}" for d, c in zip(day, clock, strict=True))
            return [*columns[: place + 1], whole, *columns[place + 2 :]]
    return columns


def is_parquet(path: Path) -> bool:
    """Whether a path is a Parquet file, or a data set of such."""
    return path.suffix == ".parquet" or is_data_set(path)


def read_parquet_table(path: Path) -> dict[str, AnyArray]:
    """Columns of a Parquet file, or of all files of a LeRobot data set; one of lists (`action`)
    becomes several, called by the joints where the data set names them, else by their place.

    Raises RecordingError.
    """
    names = names_of(path)
    tables = [_parquet(one, names) for one in (files_of(path) if path.is_dir() else [path])]
    known = [name for name in tables[0] if all(name in table for table in tables)]
    rows = sum(len(table[name]) for table in tables for name in known[:1])
    check_size(path, rows, len(known))
    return {name: np.concatenate([table.pop(name) for table in tables]) for name in known}


def _parquet(path: Path, names: Mapping[str, Sequence[str]]) -> dict[str, AnyArray]:
    table: dict[str, AnyArray] = {}
    for name, values in parquet_columns(path).items():
        if values.dtype.kind == "O" and len(values) and np.ndim(values[0]) == 1:
            block = np.stack(values.tolist())
            places: Sequence[object] = range(block.shape[1])
            joints = names.get(name, ())
            called = joints if len(joints) == len(places) else places
            table |= {f"{name}.{one}": block[:, place] for place, one in enumerate(called)}
        elif values.dtype.kind in "fiub":
            table[name] = values.astype(np.float64)
        elif values.dtype.kind == "M":
            table[name] = (values - values[0]) / np.timedelta64(1, "s")
    return table


def _numbers(cells: tuple[str, ...], decimal: str) -> AnyArray:
    if is_moment(cells[0]):
        return seconds(cells)
    found = (number(cell, decimal) for cell in cells)
    return np.array([math.nan if value is None else value for value in found])
