"""One question about a machine, and what a good answer to it looks like."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from deltactl.firmware_py.describing.products import product

Answers = dict[str, str]
"""By the key of the question."""
UNKNOWN = "unknown"
"""Answer of somebody who does not know, where that may be said: where it is the default."""
PRODUCTS = ", or a product or quotient of numbers, as 1.17*9.81*0.15 or 1/3"
_WITH_UNIT = re.compile(r"[-+]?[\d.,]+ ?[A-Za-zµ°%][A-Za-zµ°%/ ]*")
_THOUSANDS = re.compile(r"(-?\d{1,3}),(\d{3})")


@dataclass(frozen=True, slots=True)
class Notation:
    """Another way to write a number: 200x16, or 5:1."""

    reads: Callable[[str], float | None]
    """The number of such a text, None for every other."""
    least: float | None = None
    """Bound of what is so written, where it is not that of plain numbers."""


@dataclass(frozen=True, slots=True)
class Question:
    """One thing to know. `key` is also the option, `--upper-arm-mm`; unit is said in its name."""

    key: str
    text: str
    default: str | None = None
    """What Enter means; None where there is no safe guess."""
    choices: tuple[str, ...] = ()
    count: int = 1
    """So many numbers, where it is none of `choices`."""
    least: float = -math.inf
    most: float = math.inf
    too_small: Callable[[float], str] | None = None
    """What is said of a number below `least`, where more than that can be said."""
    notation: Notation | None = None
    """How people write it where it is not one plain number."""
    any_text: bool = False
    """Whether whatever is typed will do, as for a name."""
    guessed: bool = False
    """Whether the default is only what is most often met: it is said with what is missing."""
    unless: tuple[tuple[str, str], ...] = ()
    """Keys and answers of other questions, each of which leaves nothing to ask here: the default
    is taken, or where there is none, nothing is said of it."""
    only: tuple[str, str, str] | None = None
    """Key and answer of the one question with which this has a sense, and which machine that is."""

    def wrong(self, answer: str) -> str:
        """Why an answer cannot be taken, to be asked again at once; empty where it may do."""
        if self.choices and answer not in self.choices:
            return f"{answer!r}: must be {' or '.join(self.choices)}"
        if self.choices or self.any_text or answer.strip() == "none":
            return ""
        if answer == self.default == UNKNOWN:
            return ""
        found = read_numbers(answer, self.count, self.notation)
        if isinstance(found, str):
            asked = f" ({self.text})" if _WITH_UNIT.fullmatch(answer.strip()) else ""
            return f"{answer!r}: {found}{asked}"
        least = self._least(answer)
        if (smallest := min(found)) < least:
            said = self.too_small(smallest) if self.too_small else ""
            return f"{answer!r}: {said or f'must not be below {self.least:g}'}"
        return f"{answer!r}: must not be above {self.most:g}" if max(found) > self.most else ""

    def _least(self, answer: str) -> float:
        other = self.notation
        if other is None or other.least is None or other.reads(answer) is None:
            return self.least
        return other.least

    def misplaced(self, answers: Answers) -> str:
        """Why it cannot be answered beside what is answered already; empty where it can."""
        if self.only is None or answers.get(self.only[0], self.only[1]) == self.only[1]:
            return ""
        key, answer, machine = self.only
        other = answers[key]
        return (
            f"{self.option}: is of {machine} (--{key} {answer}), and this one is {other}; leave it"
            f" out, or say --{key} {answer}"
        )

    @property
    def option(self) -> str:
        """As it is typed on the command line."""
        return "--" + self.key.replace("_", "-")


def read_numbers(
    text: str, count: int, notation: Notation | None = None
) -> tuple[float, ...] | str:
    """So many numbers, or why they are not; in one number alone a comma is a decimal one."""
    if notation is not None and (value := notation.reads(text)) is not None:
        return (value,)
    if count == 1 and (found := _THOUSANDS.fullmatch(text.strip())):
        whole = "".join(found.groups())
        return f"is it {whole} or {'.'.join(found.groups())}? Write it without a comma"
    parts = [text.replace(",", ".")] if count == 1 else text.replace(",", " ").split()
    values = [product(part) for part in parts]
    numbers = tuple(one for one in values if one is not None)
    if len(numbers) < len(values):
        also = PRODUCTS if set("*/") & set(text) else ""
        also = ", without a unit" if _WITH_UNIT.fullmatch(text.strip()) else also
        return f"must be a number{also}" if count == 1 else f"must be {count} numbers"
    return numbers if len(numbers) == count else f"must be {count} numbers, with spaces between"
