"""Text laid out for one screen: parts of which as much is shown as there are lines for.

The first entry of each part is always shown, then one more of each in turn. Entries are shown
whole where all of them fit; else long ones end after a sentence or a clause. Lines are broken
between words only, and a number and its unit stay together.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

LINES = 25
"""The most lines of an answer."""
SHORT, WHOLE = 3, 99
"""Lines of an entry where room is short, and where it is not."""
_LEAD = re.compile(r"\s*(?:- |\d+\. )?")
"""Goes before a sentence, and is as wide as the indent of the lines that follow."""
_NUMBER_AND_UNIT = re.compile(r"((?<!\S)[(+\u2212-]?[\d.]+) (?=[^\W\d]|%)")
_UNIT_OF_TWO = re.compile("(?<=\u00a0N) (?=m)")
_ENDS = (
    r"(?<!^\d[.])(?<!^\d\d[.])(?<=[.!?]) (?=[A-Z])",
    r"(?<=[;:]) ",
    r"(?<=,) (?=(?:or|and|but|as|which|where|so) )",
)
"""Where an entry may end and still is a sentence."""
_ASIDE = re.compile(r" \([^()]*[a-z]{3}[^()]* [^()]*\)")
"""Words in brackets, without which a sentence is whole; a share (18 %) is none."""


@dataclass(frozen=True, slots=True)
class Part:
    """A part of what is shown: a head of its own, and entries in the order of their weight."""

    entries: Sequence[str]
    """Lines of a table row are divided by line feeds."""
    head: str = ""
    more: str = ""
    """Last line where entries are left out, {number} of them."""
    short: int = SHORT
    """Lines of an entry where room is short."""
    turns: int = 1
    """How many more entries it gets in each round; with none, what the others leave."""
    gap: bool = True
    """Whether an empty line goes before it where there is room."""
    rank: int = 0
    """Left out where there is no room for the first entry of every part: the highest first; 0 is
    never left out."""
    shown: int = 1

    @property
    def left(self) -> int:
        """How many entries are left out."""
        return max(len(self.entries) - self.shown, 0)

    def lines(self, width: int, longest: int = WHOLE) -> list[str]:
        """What is shown of it; longest: lines of an entry."""
        if not self.entries:
            return []
        longest = min(longest, self.short) if longest < WHOLE else longest
        texts = [text for entry in self.entries[: self.shown] for text in entry.split("\n")]
        more = [self.more.format(number=self.left)] if self.more and self.left else []
        body = [line for text in texts for line in shortened(text, width, longest)]
        return [*([self.head] if self.head else []), *body, *more]


def fitted(parts: Sequence[Part], width: int, most: int) -> tuple[list[Part], int]:
    """The parts with as many entries as there are lines for, and how many lines one may have.

    Where the first entries alone are too many, they are cut shorter, then parts are left out.
    """
    whole = [replace(part, shown=len(part.entries)) for part in parts]
    if _lines(whole, width, WHOLE) <= most:
        return whole, WHOLE
    filled = list(parts)
    longest = next((n for n in (SHORT, SHORT - 1) if _lines(parts, width, n) <= most), 1)
    if longest == 1:
        filled, longest = _without_the_least(filled, width, most)
    rounds = [k for turn in (1, 2) for k, part in enumerate(filled) if part.turns >= turn]
    for order in (rounds, range(len(filled))):
        filled = _grown(filled, width, most, order, longest)
    return filled, longest


def _lines(parts: Sequence[Part], width: int, longest: int) -> int:
    return sum(len(part.lines(width, longest)) for part in parts)


def _without_the_least(parts: list[Part], width: int, most: int) -> tuple[list[Part], int]:
    """The parts without those of the highest rank, as many as have to go; lines of an entry."""
    for rank in sorted({part.rank for part in parts if part.rank}, reverse=True):
        parts = [replace(one, entries=()) if one.rank == rank else one for one in parts]
        if _lines(parts, width, SHORT - 1) <= most:
            return parts, SHORT - 1
    return parts, 1


def _grown(
    parts: list[Part], width: int, most: int, order: Sequence[int], longest: int
) -> list[Part]:
    """One more entry of each in turn, until no other fits."""
    grown = True
    while grown:
        grown = False
        for k in order:
            more = [*parts[:k], replace(parts[k], shown=parts[k].shown + 1), *parts[k + 1 :]]
            if parts[k].left and _lines(more, width, longest) <= most:
                parts, grown = more, True
    return parts


def laid_out(parts: Sequence[Part], width: int, most: int) -> list[str]:
    """The parts as lines of a screen."""
    shown, longest = fitted(parts, width, most)
    return list(spaced(shown, width, longest, most))


def spaced(parts: Sequence[Part], width: int, longest: int, most: int) -> Iterator[str]:
    """The lines of all parts, with an empty line between them where there is room for all."""
    shown = [part.lines(width, longest) for part in parts]
    gaps = [number > 0 and part.gap for number, part in enumerate(parts)]
    roomy = sum(map(len, shown)) + sum(gaps) <= most
    for lines, gap in zip(shown, gaps, strict=True):
        yield from [""] if roomy and gap and lines else []
        yield from lines


def wrapped(text: str, width: int) -> list[str]:
    """Lines with a hanging indent."""
    if len(text) <= width:
        return [text]
    found = _LEAD.match(text)
    lines = textwrap.wrap(
        _UNIT_OF_TWO.sub("\u00a0", _NUMBER_AND_UNIT.sub("\\1\u00a0", text)),
        width,
        subsequent_indent=" " * (found.end() if found else 0),
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace("\u00a0", " ") for line in lines]


def shortened(text: str, width: int, most: int) -> list[str]:
    """A text as lines; of one that is too long the first sentences, without words in brackets, or
    the first clauses. The first clause is whole, whatever its lines.
    """
    lines = wrapped(text, width)
    for between in _ENDS:
        pieces = re.split(between, text)
        while len(lines) > most and len(pieces) > 1:
            pieces.pop()
            lines = wrapped(" ".join(pieces).rstrip(" ,;:.") + ".", width)
        text = " ".join(pieces)
        if len(lines) > most and (bare := _ASIDE.sub("", text)) != text:
            text = bare
            lines = wrapped(text.rstrip(" ,;:.") + ".", width)
    return lines
