"""Lines of G-code as words: a letter and a number each, comments and line numbers taken off.

The package gcodeparser, which read them before, makes G91 of G91.1, drops a line of coordinates
alone, and gives a coordinate to the nearest G word before it, though words of a line act together
(NIST IR 6556, section 3). The tests hold these words against its own where both can read a line.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

_WORD = re.compile(r"\s*([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))", re.IGNORECASE)
_COMMENT = re.compile(r"\([^()]*\)|;.*")
_CHECKSUM = re.compile(r"\*\d+\s*$")
_TEXT = re.compile(r"\s*(?:N\d+\s*)?(M117|M118)\b.*", re.IGNORECASE)
"""Messages for a display: what follows is no words."""


@dataclass(frozen=True, slots=True)
class Word:
    """A letter and its number; text: as people write it, `G1`, `G91.1`, `X-2.5`."""

    letter: str
    value: float

    @property
    def text(self) -> str:
        """The word, its number as short as it goes."""
        return f"{self.letter}{self.value:g}"


def words_of(line: str) -> list[Word]:
    """The words of one line in their order; none where it holds nothing to do.

    Raises ValueError with what cannot be read.
    """
    said = _CHECKSUM.sub("", _COMMENT.sub(" ", line)).strip()
    if not said or said.startswith("%"):
        return []
    if message := _TEXT.fullmatch(said):
        return [Word("M", float(message[1][1:]))]
    found, at = [], 0
    while at < len(said):
        word = _WORD.match(said, at)
        if word is None:
            raise ValueError(said[at:].strip()[:40])
        found.append(Word(word[1].upper(), float(word[2])))
        at = word.end()
    return found[1:] if found[0].letter == "N" else found
