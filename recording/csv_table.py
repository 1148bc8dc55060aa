"""CSV with numpy and the standard library: a fast way for clean files, a slow one that explains."""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import math
import re
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from foundation.errors import RecordingError
from recording.flat import UNITS, AnyArray, FlatRecording, from_columns

_EMPTY_CELL = re.compile(r"(?:^(?=,)|(?<=,)(?=,|$))", re.MULTILINE)
_NO_VALUE = frozenset({"", "nan", "na", "n/a", "null", "none", "-"})
_FIRST_LINE = 2
_GZIP_LEVEL = 6
_MOST_BYTES = 2**29
"""Unpacked: a day of rows at 50 Hz. Tables take about five times that in memory."""


def read_csv(path: Path) -> FlatRecording:
    """Read `.csv` or `.csv.gz`. Raises RecordingError, naming file and line."""
    text = read_text(path)
    head, _, body = text.partition("\n")
    names = _heading(path, head)
    if not body.strip():
        raise RecordingError(f"{path}: has a heading but no rows")
    columns = _fast(names, body) or _slow(path, names, text)
    return from_columns(columns, str(path), first_line=_FIRST_LINE)


def write_csv(recording: FlatRecording, path: Path) -> None:
    """Write `.csv` or `.csv.gz`; numbers keep every digit they have. Raises RecordingError."""
    columns: dict[str, AnyArray] = {"t": recording.t_s, **recording.columns, **recording.extra}
    heading = io.StringIO()
    csv.writer(heading, lineterminator="\n").writerow(columns)
    cells = [_cells(values) for values in columns.values()]
    rows = "\n".join(map(",".join, zip(*cells, strict=True)))
    data = f"{heading.getvalue()}{rows}\n".encode()
    try:
        # A gzip header without a time: the same table gives the same bytes.
        path.write_bytes(gzip.compress(data, _GZIP_LEVEL, mtime=0) if _is_packed(path) else data)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written ({error.strerror})") from error


def _is_packed(path: Path) -> bool:
    return path.suffix == ".gz"


def read_text(path: Path, any_encoding: bool = False) -> str:
    """Text of a file, unpacked if need be. Raises RecordingError when it is none.

    any_encoding: also UTF-16 with its mark, and what older Windows programs write.
    """
    try:
        with gzip.open(path) if _is_packed(path) else path.open("rb") as file:
            data = file.read(_MOST_BYTES + 1)
        if len(data) > _MOST_BYTES:
            raise RecordingError(f"{path}: has more than {_MOST_BYTES // 2**20} MiB; cut it up")
        text = _decoded(data, any_encoding)
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise RecordingError(f"{path}: is not a whole gzip file ({error})") from error
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path}: is not a text file (byte {error.start})") from error
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from error
    if not text.strip():
        raise RecordingError(f"{path}: is empty")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _decoded(data: bytes, any_encoding: bool) -> str:
    if any_encoding and data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        if not any_encoding or b"\0" in data[:1000]:
            raise
        return data.decode("cp1252")


def _heading(path: Path, head: str) -> list[str]:
    names = [name.strip() for name in next(csv.reader([head]))]
    if "t" not in names:
        raise RecordingError(
            f"{path}:1: has no column 't'; it has {', '.join(names)[:200]};"
            f" type: deltactl diagnose --inspect {path}"
        )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise RecordingError(f"{path}:1: column '{twice[0]}' stands here twice")
    return names


def _fast(names: list[str], body: str) -> dict[str, AnyArray] | None:
    """All-number tables, by numpy's own parser; None for anything it cannot take."""
    try:
        table = np.loadtxt(
            _EMPTY_CELL.sub("nan", body).splitlines(),
            delimiter=",",
            dtype=np.float64,
            ndmin=2,
            comments=None,
        )
    except ValueError:
        return None
    if table.shape[1] != len(names) or len(table) != _lines(body):
        return None
    return {name: np.ascontiguousarray(table[:, column]) for column, name in enumerate(names)}


def _lines(body: str) -> int:
    """Rows there should be: an empty line in between is an error that the slow way reports."""
    return body.rstrip("\n").count("\n") + 1


def _slow(path: Path, names: list[str], text: str) -> dict[str, AnyArray]:
    """Cell by cell: texts in extra columns, quotes, and the line of whatever is wrong."""
    cells: list[list[str]] = [[] for _ in names]
    for line, row in _rows(path, text):
        if len(row) != len(names):
            raise RecordingError(f"{path}:{line}: has {len(row)} cells, the heading {len(names)}")
        for column, cell in zip(cells, row, strict=True):
            column.append(cell.strip())
    return {name: _column(path, name, values) for name, values in zip(names, cells, strict=True)}


def _rows(path: Path, text: str) -> Iterator[tuple[int, list[str]]]:
    lines = csv.reader(io.StringIO(text.rstrip("\n")))
    try:
        next(lines)
        for row in lines:
            yield lines.line_num, row
    except csv.Error as error:
        raise RecordingError(f"{path}:{lines.line_num}: is not CSV ({error})") from error


def _column(path: Path, name: str, cells: list[str]) -> AnyArray:
    values = np.empty(len(cells))
    for row, cell in enumerate(cells):
        try:
            values[row] = math.nan if cell.lower() in _NO_VALUE else float(cell)
        except ValueError:
            if name not in UNITS:
                return np.array(cells, dtype=np.str_)
            raise RecordingError(
                f"{path}:{row + _FIRST_LINE}: {name} must be a number (got {cell[:40]!r})"
            ) from None
    return values


def _cells(values: AnyArray) -> list[str]:
    if values.dtype.kind not in "fiub":
        return [_quoted(str(value)) for value in values]
    return [_number(value) for value in values.tolist()]


def _number(value: float) -> str:
    if value != value:
        return ""
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n\r') else text
