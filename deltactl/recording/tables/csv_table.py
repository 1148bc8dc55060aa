"""CSV with numpy and the standard library: a fast way for clean files, a slow one that explains. A
text is read whole, packed or not, or in blocks of whole lines where it may be a day long.
"""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import math
import re
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, NamedTuple, cast

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import write_whole
from deltactl.recording.tables.cells import not_a_number, number, wrong_count
from deltactl.recording.tables.flat import (
    MOST_COLUMNS,
    UNITS,
    AnyArray,
    FlatRecording,
    are_poses,
    from_columns,
)

_MOST_TEXT_BYTES = 2**27
"""Unpacked, of a text that is held whole: its cells take about ten times that in memory."""
_BLOCK_BYTES = 2**22


class Block(NamedTuple):
    """Some whole lines, without the last newline; `line` is the number of the first, from 1."""

    text: str
    line: int
    read_bytes: int
    """How much of the file, packed as it is, has been read so far."""


def read_text(path: Path, any_encoding: bool = False) -> str:
    """Text of a file, unpacked if need be. Raises RecordingError when it is none.

    any_encoding: also UTF-16 with its mark, and what older Windows programs write.
    """
    with _opened(path) as (file, _):
        data = file.read(_MOST_TEXT_BYTES + 1)
        if len(data) > _MOST_TEXT_BYTES:
            raise RecordingError(
                f"{path}: has more than {_MOST_TEXT_BYTES // 2**20} MiB; cut it up, or write it as "
                "Parquet or as CSV with the names of docs/reference/columns.md"
            )
        text = _decoded(data, any_encoding)
    if not text.strip():
        raise RecordingError(f"{path}: is empty")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def blocks(path: Path, most_bytes: int) -> Iterator[Block]:
    """A UTF-8 text in blocks of whole lines; no block ends within a quoted cell.

    Raises RecordingError when it is no text, or unpacks to more than `most_bytes`.
    """
    decoder = codecs.getincrementaldecoder("utf-8-sig")()
    waiting, line, size = "", 1, 0
    with _opened(path) as (file, packed):
        while data := file.read(_BLOCK_BYTES):
            size += len(data)
            if size > most_bytes:
                raise RecordingError(f"{path}: has more than {most_bytes // 2**20} MiB; cut it up")
            # A return at the end of a piece waits for the newline that may follow it.
            waiting += decoder.decode(data)
            held = waiting.endswith("\r")
            text = _with_newlines(waiting[:-1] if held else waiting)
            end = text.rfind("\n")
            if end < 0 or text.count('"', 0, end) % 2:
                if len(text) > 4 * _BLOCK_BYTES:
                    raise RecordingError(f"{path}:{line}: a line or cell has no end")
                waiting = text + "\r" * held
                continue
            yield Block(text[:end], line, packed.tell())
            line += text.count("\n", 0, end) + 1
            waiting = text[end + 1 :] + "\r" * held
        waiting = _with_newlines(waiting + decoder.decode(b"", final=True))
        if waiting:
            yield Block(waiting, line, packed.tell())


@contextmanager
def _opened(path: Path) -> Iterator[tuple[IO[bytes], IO[bytes]]]:
    """The file's bytes unpacked, and the file itself."""
    try:
        with path.open("rb") as packed:
            if path.suffix != ".gz":
                yield packed, packed
                return
            with gzip.open(packed) as file:
                yield cast(IO[bytes], file), packed
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise RecordingError(f"{path}: is not a whole gzip file ({error})") from error
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path}: is not a text file (byte {error.start})") from error
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror})") from error


def _decoded(data: bytes, any_encoding: bool) -> str:
    if any_encoding and data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        if not any_encoding or b"\0" in data[:1000]:
            raise
        return data.decode("cp1252")


def _with_newlines(text: str) -> str:
    return text.replace("\r\n", "\n").replace("\r", "\n")


Progress = Callable[[str], None]
_NO_VALUE = frozenset({"", "nan", "na", "n/a", "null", "none", "-"})
_FIRST_LINE = 2
_GZIP_LEVEL = 6
_MOST_BYTES = 2**30
"""Unpacked: more than a day of rows at 50 Hz; the numbers take about as much in memory."""


def read_csv(path: Path, progress: Progress = lambda _: None) -> FlatRecording:
    """Read `.csv` or `.csv.gz`, block by block. Raises RecordingError, naming file and line."""
    names: list[str] = []
    parts: list[dict[str, AnyArray]] = []
    rows, size = 0, max(path.stat().st_size, 1) if path.is_file() else 1
    for block in _without_empty_end(blocks(path, _MOST_BYTES)):
        body, line = block.text, block.line
        if not names:
            head, _, body = body.partition("\n")
            names, line = _heading(path, head), line + 1
            if not body:
                continue
        part = all_numbers(names, body) or _slow(path, names, Block(body, line, 0))
        parts.append(part)
        rows += len(next(iter(part.values())))
        if len(parts) > 1:
            progress(f"reading {path.name}: {rows} rows, {block.read_bytes / size:.0%}")
    if not names:
        raise RecordingError(f"{path}: is empty")
    if not parts:
        raise RecordingError(f"{path}: has a heading but no rows")
    columns = {name: _joined(parts, name) for name in names}
    return from_columns(columns, str(path), range(_FIRST_LINE, _FIRST_LINE + rows))


def _without_empty_end(found: Iterator[Block]) -> Iterator[Block]:
    """Blocks without the empty lines at the end of the file."""
    held: Block | None = None
    for block in found:
        if held is not None:
            if not block.text.strip("\n"):
                continue
            yield held
        held = block
    if held is not None and (text := held.text.rstrip("\n")).strip():
        yield held._replace(text=text)


def _joined(parts: list[dict[str, AnyArray]], name: str) -> AnyArray:
    """A column of all blocks, taken out of them; texts where any block has texts."""
    found = [part.pop(name) for part in parts]
    if any(values.dtype.kind == "U" for values in found):
        found = [v if v.dtype.kind == "U" else np.array(_cells(v), dtype=np.str_) for v in found]
    return found[0] if len(found) == 1 else np.concatenate(found)


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
        packed = path.suffix == ".gz"
        write_whole(path, gzip.compress(data, _GZIP_LEVEL, mtime=0) if packed else data)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written ({error.strerror})") from error


def _heading(path: Path, head: str) -> list[str]:
    names = [name.strip() for name in next(csv.reader([head]))]
    if "t" not in names and not are_poses(names):
        raise RecordingError(
            f"{path}:1: has no column 't'; it has {', '.join(names)[:200]}"
        ).with_typed(f"; type: deltactl inspect {path}")
    if len(names) > MOST_COLUMNS:
        raise RecordingError(f"{path}:1: has {len(names)} columns, at most {MOST_COLUMNS} are read")
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice:
        raise RecordingError(f"{path}:1: column '{twice[0]}' occurs here twice")
    return names


def all_numbers(
    names: Sequence[str], body: str, separator: str = ","
) -> dict[str, AnyArray] | None:
    """All-number tables, by numpy's own parser; None for anything it cannot take."""
    mark = re.escape(separator)
    empty = re.compile(rf"(?:^(?={mark})|(?<={mark})(?={mark}|$))", re.MULTILINE)
    try:
        table = np.loadtxt(
            empty.sub("nan", body).splitlines(),
            delimiter=separator,
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
    return body.count("\n") + 1


def _slow(path: Path, names: list[str], block: Block) -> dict[str, AnyArray]:
    """Cell by cell: texts in extra columns, quotes, and the line of whatever is wrong."""
    cells: list[list[str]] = [[] for _ in names]
    for line, row in _rows(path, block):
        if len(row) != len(names):
            raise wrong_count(path, line, len(row), len(names))
        for column, cell in zip(cells, row, strict=True):
            column.append(cell.strip())
    return {
        name: _column(path, name, values, block.line)
        for name, values in zip(names, cells, strict=True)
    }


def _rows(path: Path, block: Block) -> Iterator[tuple[int, list[str]]]:
    lines = csv.reader(io.StringIO(block.text))
    before = block.line - 1
    try:
        for row in lines:
            yield before + lines.line_num, row
    except csv.Error as error:
        raise RecordingError(f"{path}:{before + lines.line_num}: is not CSV ({error})") from error


def _column(path: Path, name: str, cells: list[str], first_line: int) -> AnyArray:
    values = np.empty(len(cells))
    for row, cell in enumerate(cells):
        value = math.nan if cell.lower() in _NO_VALUE else number(cell)
        if value is None:
            if name not in UNITS:
                return np.array(cells, dtype=np.str_)
            raise not_a_number(path, row + first_line, name, cell)
        values[row] = value
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
