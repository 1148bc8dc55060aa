"""The lines of a G-code file, whatever editor, post-processor or tape punch wrote it.

A comment may hold any byte. What moves the robot is plain ASCII, so a byte that is no ASCII is
refused where words are read (gcode_words.py), and never cut.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from pathlib import Path

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import TooLong, read_plain

MAX_BYTES = 20_000_000
_WIDE = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
_LEADER = "\x00\x02\x03\x04\x11\x12\x13\x14\x1a\x7f \t\r\n\x0b\x0c"
"""What old controllers and serial lines put before and behind a program: NUL, start and end of
text, XON and XOFF, Ctrl-Z, rub-out."""
_BREAK = re.compile(r"\r*\n\r+(?!\n)|\r*\n|\r")
"""Only CR and LF end a line: str.splitlines also breaks at bytes that stand in comments."""


def numbered_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Lines from 1, without what ends them. Raises MissingFile, ConfigError."""
    try:
        content = read_plain(path, MAX_BYTES)
    except TooLong:
        raise ConfigError(
            f"{path}: is longer than {MAX_BYTES:,} bytes; split it into several jobs"
        ) from None
    text = _decoded(path, content)
    begin = len(text) - len(text.lstrip(_LEADER))
    number = 1 + sum(1 for _ in _BREAK.finditer(text, 0, begin))
    text = text.rstrip(_LEADER)
    at = begin
    for found in _BREAK.finditer(text, begin):
        yield number, text[at : found.start()]
        number, at = number + 1, found.end()
    yield number, text[at:]


def _decoded(path: Path, content: bytes) -> str:
    """Text of UTF-8 or UTF-16 by its mark, else of UTF-8 or Latin-1, which cannot fail."""
    wide = _WIDE.get(content[:2])
    try:
        if wide is not None:
            return content[2:].decode(wide)
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if wide is not None:
            raise ConfigError(f"{path}: is no G-code ({error})") from error
        return content.removeprefix(codecs.BOM_UTF8).decode("latin-1")
