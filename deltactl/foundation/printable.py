"""Text of others, made fit for a terminal, a log or a page: what cannot be printed is shown.

An escape sequence in a name can rewrite a terminal's title or hide a line, a line break forges
an entry of a log, and a mark that turns the direction of reading makes one name look like
another. All of them come out as what they are: `\x1b`, `\u202e`.
"""

from __future__ import annotations

import math
import re

_HARMFUL = r"\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff"
"""Controls, half characters, line and paragraph separators, and marks of direction (Unicode's
categories Cc, Cs, Zl, Zp and Bidi_Control); line feed and tab are looked at apart."""
_IN_A_LINE = re.compile(rf"[{_HARMFUL}\t\n]")
_IN_A_TEXT = re.compile(rf"[{_HARMFUL}]")


_BYTES = ("kB", "MB", "GB")


def is_printable(text: str, layout: bool = False) -> bool:
    """Whether nothing in it acts instead of being seen; `layout`: line feeds and tabs may."""
    return not (_IN_A_TEXT if layout else _IN_A_LINE).search(text)


def printable(text: str, layout: bool = False) -> str:
    """The text with everything that would act written out."""
    return (_IN_A_TEXT if layout else _IN_A_LINE).sub(_written_out, text)


def _written_out(found: re.Match[str]) -> str:
    return found.group().encode("unicode_escape").decode("ascii")


def plain(value: float, decimals: int = 6, digits: int = 6) -> str:
    """A number of at most so many significant digits, and none below its last decimal.

    What is left of a subtraction is nothing: -5.55e-14 is 0.
    """
    return f"{round(value, decimals) + 0.0:.{digits}g}"


def file_size(size_bytes: int) -> str:
    """'812 bytes', '3.4 kB', '12 MB': two digits or more, whatever the size."""
    if size_bytes < 1000:
        return count(size_bytes, "byte")
    power = min(int(math.log10(size_bytes)) // 3, len(_BYTES))
    size = size_bytes / 1000.0**power
    return f"{size:.{1 if size < 10.0 else 0}f} {_BYTES[power - 1]}"


def count(number: int, one: str, more: str | None = None) -> str:
    """'one finding', '3 findings'."""
    if number == 1:
        return f"one {one}"
    return f"{number} {more or one + 's'}"
