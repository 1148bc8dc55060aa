"""Text of a file, packed or not: whole, or in blocks of whole lines for what may be a day long."""

from __future__ import annotations

import codecs
import gzip
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, NamedTuple, cast

from deltactl.foundation.errors import RecordingError

_MOST_BYTES = 2**27
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
        data = file.read(_MOST_BYTES + 1)
        if len(data) > _MOST_BYTES:
            raise RecordingError(
                f"{path}: has more than {_MOST_BYTES // 2**20} MiB; cut it up, or write it as "
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
