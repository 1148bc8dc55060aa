"""Tables of others: any names, any separator, lines before the heading, or no heading at all."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.recording.tables.binary_tables import (
    check_size,
    files_of,
    is_data_set,
    names_of,
    parquet_columns,
)
from deltactl.recording.tables.cells import (
    is_date,
    is_moment,
    is_time_of_day,
    number,
    seconds,
    text_among_numbers,
    wrong_count,
)
from deltactl.recording.tables.csv_table import all_numbers, read_text
from deltactl.recording.tables.flat import AnyArray
from deltactl.recording.tables.table_format import split

COMMENTS = ("#", "%", "//", ";")
"""How a comment begins; the last only where no number follows it, as it may separate cells."""
_MOST_SHOWN = 40
_ONE_CHARACTER = frozenset({",", ";", "\t", "|"})
_BLOCK = 2**22
Row = tuple[int, str, list[str]]
"""Number of the line, its text, and its cells."""
_WITH_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")


@dataclass(frozen=True, slots=True)
class ForeignTable:
    """A table as it was read.

    columns: numbers by name, shape (n,) each; NaN where a cell holds no number. lines: the line of
    each row, from 1. dated: names of the columns of dates and times of day.
    """

    columns: dict[str, AnyArray]
    lines: Sequence[int]
    dated: set[str]


def read_table(
    path: Path,
    skip_lines: int = 0,
    heading: Sequence[str] = (),
    separator: str = ",",
    decimal: str = ".",
    tell: Callable[[str], None] = lambda _: None,
) -> ForeignTable:
    """Read a table of text.

    heading: names of the columns where the file has none. Dates and times of day are seconds since
    the first row's. tell: takes words for comments and a footer that were left out.
    Raises RecordingError.
    """
    text = read_text(path, any_encoding=True)
    if (plain := _of_numbers(text, skip_lines, heading, separator, decimal)) is not None:
        return plain
    lines = text.split("\n")[skip_lines:]
    if not heading:
        if not lines:
            raise RecordingError(f"{path}: has no line {skip_lines + 1} with a heading")
        heading = split(lines[0], separator)
        lines, skip_lines = lines[1:], skip_lines + 1
    rows, left_out = without_remarks(
        [
            (n, text, split(text, separator))
            for n, text in enumerate(lines, skip_lines + 1)
            if text.strip()
        ],
        len(heading),
        decimal,
    )
    if left_out:
        tell(f"is read {left_out}")
    _refuse_other_widths(path, rows, len(heading))
    for said in text_among_numbers(heading, rows, decimal):
        tell(said)
    columns = list(zip(*(parts for _, _, parts in rows), strict=True))
    _refuse_commas(path, heading, columns, decimal)
    named = dict(zip(heading, _with_days(columns), strict=True))
    return ForeignTable(
        {name: _numbers(column, decimal) for name, column in named.items()},
        [line for line, _, _ in rows],
        {name for name, column in named.items() if is_moment(column[0])},
    )


def _of_numbers(
    text: str, skip_lines: int, heading: Sequence[str], separator: str, decimal: str
) -> ForeignTable | None:
    """Read a table that holds only numbers, block by block; None where it holds anything else.

    A day's log has millions of lines, which take minutes cell by cell.
    """
    first = skip_lines + (not heading)
    *above, body = text.rstrip("\n").split("\n", first)
    remarks = body.startswith(COMMENTS) or any(f"\n{mark}" in body for mark in COMMENTS)
    if len(above) < first or separator not in _ONE_CHARACTER or remarks:
        return None
    if decimal == ",":
        if separator == "," or "." in body:
            return None
        body = body.replace(",", ".")
    names, parts = heading or split(above[-1], separator), []
    for block in _blocks(body):
        if (part := all_numbers(names, block, separator)) is None:
            return None
        parts.append(part)
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    rows = len(next(iter(columns.values())))
    return ForeignTable(columns, range(first + 1, first + 1 + rows), set())


def _blocks(body: str) -> Iterator[str]:
    """Whole lines, some million characters at once, without the last newline of each."""
    begin = 0
    while begin <= len(body):
        end = body.find("\n", begin + _BLOCK)
        end = len(body) if end < 0 else end
        yield body[begin:end]
        begin = end + 1


def _refuse_other_widths(path: Path, rows: Sequence[Row], width: int) -> None:
    """Raise RecordingError for a table without rows, or with a row of more or fewer cells."""
    if not rows:
        raise RecordingError(f"{path}: has a heading but no rows")
    for line, _, parts in rows:
        if len(parts) != width:
            raise wrong_count(path, line, len(parts), width)


def _refuse_commas(
    path: Path, heading: Sequence[str], columns: Sequence[tuple[str, ...]], decimal: str
) -> None:
    """Raise RecordingError for numbers with a comma where a point is the decimal mark."""
    for name, column in zip(heading, columns, strict=True):
        if decimal == "." and all(_WITH_COMMA.fullmatch(cell) for cell in column):
            raise RecordingError(
                f"{path}: {name} has a decimal comma ({column[0]}); add: --set decimal=,"
            )


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


def without_remarks(rows: Sequence[Row], width: int, decimal: str) -> tuple[list[Row], str]:
    """Rows without comments and without a last line of text, and words for what was left out;
    empty words where nothing was.
    """
    kept = [row for row in rows if not _is_comment(row, width, decimal)]
    comments, footer = len(rows) - len(kept), ""
    if len(kept) > 1 and _is_footer(kept[-1], width, decimal):
        footer = kept.pop()[1].strip()[:_MOST_SHOWN]
    lines = "one comment line" if comments == 1 else f"{comments} comment lines"
    parts = ([lines] if comments else []) + ([f"the last line ('{footer}')"] if footer else [])
    return kept, f"without {' and '.join(parts)}" if parts else ""


def _is_comment(row: Row, width: int, decimal: str) -> bool:
    _, text, cells = row
    if not text.lstrip().startswith(COMMENTS):
        return False
    return len(cells) != width or not _how_many_numbers(cells, decimal)


def _is_footer(row: Row, width: int, decimal: str) -> bool:
    """Whether a line begins with a word and is no row; one cut off begins with a number."""
    _, _, cells = row
    begins = not cells[0] or is_moment(cells[0]) or number(cells[0], decimal) is not None
    return not begins and (len(cells) != width or not _how_many_numbers(cells, decimal))


def _how_many_numbers(cells: Sequence[str], decimal: str) -> int:
    return sum(number(cell, decimal) is not None or is_moment(cell) for cell in cells)
