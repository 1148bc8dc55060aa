"""Lines of a G-code file, whatever wrote it, and the words of each: a letter and a number.

A comment may hold any byte. Every other character of a line is part of a word, a line number or a
checksum, or the line is refused. The package gcodeparser makes G91 of G91.1, drops a line of
coordinates alone, and gives a coordinate to the nearest G word before it, though words of a line
act together (NIST IR 6556, section 3). The tests compare these words with its own where both can
read a line.
"""

from __future__ import annotations

import codecs
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import TooLong, read_plain

MAX_BYTES = 20_000_000
_WIDE = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
_LEADER = "\x00\x02\x03\x04\x11\x12\x13\x14\x1a\x7f \t\r\n\x0b\x0c"
"""What old controllers and serial lines put before and behind a program: NUL, start and end of
text, XON and XOFF, Ctrl-Z, rub-out."""
_BREAK = re.compile(r"\r*\n\r+(?!\n)|\r*\n|\r")
"""Only CR and LF end a line: str.splitlines also breaks at bytes that occur in comments."""


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


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_WORD = re.compile(rf"\s*([A-Za-z])[ \t]*({_NUMBER})", re.ASCII)
_BARE = re.compile(r"\s*([A-Za-z])(?=\s|$)", re.ASCII)
_COMPUTED = re.compile(r"[#\[\]=<>]")
_O_WORD = re.compile(r"[oO]\s*(?:\d|<|#|\[)")
_CHECKSUM = re.compile(r"(.*?)\*\s*(\d+)\s*", re.DOTALL)
_NUMBERED = re.compile(r"\s*[nN][ \t]*(\d{1,9})(?![\d.])", re.ASCII)
_POWER = re.compile(r"(?<=[\d.])[eE](?=[-+]?\d)", re.ASCII)
_PADDED_POWER = re.compile(r"[eE][-+]\d\d+(?![\d.])", re.ASCII)
_MACRO = re.compile(r"[A-Za-z_]{3,}")
DELETED = re.compile(r"([ \t]*(?:[nN][ \t]*\d+)?[ \t]*)/(?:[1-9](?!\d))?", re.ASCII)
"""Block delete: '/' before or behind the line number; Fanuc numbers the switches for it."""
BLANK = " \t\f\v"
_SHOWN = 40


@dataclass(frozen=True, slots=True)
class Word:
    """A letter and its number, None where there is none; text: as people write it, `G91.1`.

    rest: what follows a word that takes all that follows it, as `M117`; None for any other.
    """

    letter: str
    value: float | None
    rest: str | None = None

    @property
    def text(self) -> str:
        """The word, its number as short as it goes."""
        return self.letter if self.value is None else f"{self.letter}{self.value:g}"


TakesRest = Callable[[float, str], bool]


def words_of(line: str, takes_rest: TakesRest = lambda number, rest: False) -> list[Word]:
    """The words of one line in their order; none where it holds nothing to do.

    takes_rest: whether an M word of that number takes all that follows it on its line. Raises
    ValueError with what cannot be read, and what to do.
    """
    said = _without_checksum(line) if "*" in line else line
    if "(" in said or ")" in said or ";" in said:
        said = without_comments(said)[0]
    numbered = _NUMBERED.match(said)
    at = numbered.end() if numbered else 0
    said = said.rstrip(BLANK)
    words: list[Word] = []
    while at < len(said):
        found = _WORD.match(said, at) or _BARE.match(said, at)
        if found is None:
            raise ValueError(_unread(said, at))
        letter, at = found[1].upper(), found.end()
        value = float(found[2]) if found.re is _WORD else None
        if value is not None and not math.isfinite(value):
            raise ValueError(f"a number of {len(found[2])} digits; nothing here is that large")
        if letter == "E" and value is not None and _is_power(said, found):
            raise ValueError(
                f"'{_around(said, found.start())}' may be a number with an exponent, or a word E;"
                " write the number out, or a space before E"
            )
        if letter == "M" and value is not None and takes_rest(value, said[at:]):
            words.append(Word(letter, value, said[at:].strip()))
            break
        words.append(Word(letter, value))
    return words


def without_comments(line: str) -> tuple[str, str]:
    """A line without its comments, and the text of them.

    Raises ValueError for a bracket without its other one, and for words between nested comments:
    some controllers end a comment at the first closing bracket, and would carry them out.
    """
    kept: list[str] = []
    comments: list[str] = []
    depth = begin = closed = 0
    for at, sign in enumerate(line):
        if sign == ";" and depth == 0:
            kept.append(line[begin:at])
            return " ".join(kept), " ".join((*comments, line[at + 1 :].strip()))
        if sign == "(":
            if depth == 0:
                kept.append(line[begin:at])
                begin, closed = at + 1, 0
            depth += 1
        elif sign == ")":
            if depth == 0:
                raise ValueError("a bracket ')' closes no comment; delete it")
            depth -= 1
            closed = closed or at
            if depth == 0:
                if _WORD.search(line[closed:at]):
                    raise ValueError(
                        f"'{line[closed + 1 : at].strip()[:_SHOWN]}' is in a comment for some"
                        " controllers and not for others; take the inner brackets away"
                    )
                comments.append(line[begin:at].strip())
                begin = at + 1
    if depth:
        raise ValueError("a comment that '(' begins does not end; close it with ')'")
    kept.append(line[begin:])
    return " ".join(kept), " ".join(comments)


def _without_checksum(line: str) -> str:
    """A line without the checksum that hosts of 3D printers add, which must be right."""
    found = _CHECKSUM.fullmatch(line.partition(";")[0])
    if found is None or found[1].count("(") != found[1].count(")"):
        return line  # a star in a comment; any other is no word
    is_sum = 0
    for byte in found[1].encode("utf-8"):
        is_sum ^= byte
    if int(found[2]) != is_sum:
        raise ValueError(
            f"the checksum *{found[2]} is not that of the line ({is_sum}): the line was changed or"
            " damaged; correct it, or delete the checksum"
        )
    return found[1]


def _is_power(said: str, found: re.Match[str]) -> bool:
    """Whether an E behind digits may be an exponent: only between separated words it cannot be
    a word, as one writes `G1X5E2` or `G1 X5 E2`."""
    if _POWER.match(said, found.start()) is None:
        return False
    if _PADDED_POWER.match(said, found.start()):
        return True
    words = said.strip()
    cases = {sign.isupper() for sign in words if sign.isalpha()}
    return " " in words or "\t" in words or len(cases) > 1


def _unread(said: str, at: int) -> str:
    """Why nothing can be read there, and what to do."""
    rest = said[at:].strip(BLANK)
    what = f"'{rest[:_SHOWN]}' is not understood"
    if DELETED.match(said):
        return (
            f"'{said.strip()[:_SHOWN]}' may be carried out or not, as a switch at the controller"
            " says: --block-delete leaves such lines out, --no-block-delete carries them out"
        )
    if _O_WORD.match(rest) or _O_WORD.match(said.lstrip()):
        return f"{what}: O words (loops, calls) are not carried out; write the moves out"
    if _COMPUTED.search(rest) and not _MACRO.match(rest):
        return (
            f"{what}: parameters and expressions are not computed; let the program that made the"
            " file write numbers"
        )
    if _MACRO.match(rest) and not said[:at].strip():
        return f"{what}: is it a macro of the machine? write its moves out, or delete the line"
    odd = next((sign for sign in rest if not 32 <= ord(sign) < 127 and sign != "\t"), None)
    if odd is not None and rest.index(odd) < 2:
        return f"{rest[:_SHOWN]!a} is not understood: {odd!a} is no character of G-code"
    if rest.startswith(",") or rest[1:2] == ",":
        return f"{what}: is it a decimal comma? numbers have a decimal point"
    return what


def _around(said: str, at: int) -> str:
    begin = max(said.rfind(" ", 0, at), said.rfind("\t", 0, at)) + 1
    return said[begin : begin + _SHOWN].split()[0]
