"""One question about a machine, and how typed answers are read: 200x8, 5:1, 1.17*9.81."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_PRODUCT = re.compile(rf"\s*{_NUMBER}(?:\s*[*/]\s*{_NUMBER})*\s*", re.ASCII)
_PART = re.compile(rf"([*/]?)\s*({_NUMBER})", re.ASCII)


def product(text: str) -> float | None:
    """The number that a text is or comes to, from left to right; None where it is none, infinite,
    or divided by zero.
    """
    if _PRODUCT.fullmatch(text) is None:
        return None
    value = 1.0
    for sign, part in _PART.findall(text):
        number = float(part)
        if sign == "/" and not number:
            return None
        value = value / number if sign == "/" else value * number
    return value if math.isfinite(value) else None


USUAL_STEPS = 200.0
"""Full steps for one turn of nearly every stepper: 1.8 degrees each."""
FULL_STEPS = (200.0, 400.0)
"""For one turn of motors with 1.8 or 0.9 degrees a step."""
LEAST_PULSES = 100.0
"""For one turn: below are the settings of drives (2 to 64), far from what turns an arm."""
SETTINGS = (128.0, 256.0)
"""Microsteps of one full step that drives offer too, and that may be pulses for one turn."""

_RATIO = re.compile(r"([.\d]+) ?: ?([.\d]+)")
"""A gear's ratio as its maker writes it, 5:1, or as its user does, 1:5."""
_BOTH = re.compile(r"([1-9]\d{0,5}) ?[x*×] ?([1-9]\d{0,3})", re.IGNORECASE)
"""Full steps of a turn, and the microsteps of each: 200x16."""
TIN_CAN_STEPS = 32
"""Full steps of the motor in a 28BYJ-48, before its gear of 63.68:1."""


def too_few_pulses(pulses: float) -> str:
    """What is said of pulses for one turn that can only be microsteps of one full step."""
    return (
        f"{pulses:g} microsteps a full step? For a motor with {USUAL_STEPS:g} steps a turn write"
        f" --microsteps-per-rev {USUAL_STEPS * pulses:g}. For a motor with fewer, write both: a"
        f" 28BYJ-48 has {TIN_CAN_STEPS}, in half steps --microsteps-per-rev {TIN_CAN_STEPS}x2"
        " --gear-ratio 63.68"
    )


def of_both(text: str) -> float | None:
    """Pulses for one turn from 200x16, full steps and microsteps of each; None for other texts."""
    found = _BOTH.fullmatch(text.strip())
    return float(int(found[1]) * int(found[2])) if found else None


def of_ratio(text: str) -> float | None:
    """The turns of the motor for one of the arm that 4:1 and 1:4 both mean; None for no such text.

    People write a reduction either way round, and no arm is geared up.
    """
    found = _RATIO.fullmatch(text.strip())
    try:
        first, second = (float(part) for part in found.groups()) if found else (0.0, 0.0)
    except ValueError:  # two points in a number
        return None
    return max(first, second) / min(first, second) if min(first, second) > 0.0 else None


def ratio_remark(text: str) -> list[str]:
    """How a ratio with a colon was read."""
    ratio = of_ratio(text)
    if ratio is None:
        return []
    times = "once" if ratio == 1.0 else f"{ratio:.6g} times"
    return [
        f"--gear-ratio:    {text.strip()} is read as {ratio:.6g}: the motor turns {times} for one"
        " turn of what it drives"
    ]


def pulses_remark(text: str, pulses: float) -> list[str]:
    """How full steps and microsteps were read, and what is seldom meant, and may be right."""
    if of_both(text) is not None:
        return [f"--microsteps-per-rev: {text.strip()} is read as {pulses:g} pulses for one turn"]
    if pulses in FULL_STEPS:
        return [
            f"look here:       {pulses:g} pulses for one turn are full steps; if the drive makes"
            " microsteps, give the pulses that it is set to (1600 for 8 microsteps a step)"
        ]
    if pulses < USUAL_STEPS or pulses in SETTINGS:
        return [
            f"look here:       {pulses:g} pulses for one whole turn of the motor are few; if the"
            f" drive is set to {pulses:g} microsteps a step, write {USUAL_STEPS * pulses:g}"
        ]
    return []


Answers = dict[str, str]
"""By the key of the question."""
UNKNOWN = "unknown"
"""Answer of somebody who does not know, where that may be said."""
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
    whole: bool = False
    """Whether it counts something."""
    any_text: bool = False
    """Whether whatever is typed will do, as for a name."""
    unknown: bool = False
    """Whether the answer may be `UNKNOWN`."""
    guessed: bool = False
    """Whether the default is only what is most often met: it is said with what is missing."""
    unless: tuple[tuple[str, str], ...] = ()
    """Keys and answers of other questions, each of which leaves nothing to ask here: the default
    is taken, or where there is none, nothing is said of it."""
    only: tuple[str, str, str] | None = None
    """Key and answer of the one question with which this has a sense, and which machine that is."""

    def wrong(self, answer: str) -> str:
        """Why an answer cannot be taken, to be asked again at once; empty where it may do."""
        if self.choices:
            why = "" if answer in self.choices else f"must be {' or '.join(self.choices)}"
        elif self.any_text or answer.strip() == "none" or (self.unknown and answer == UNKNOWN):
            why = ""
        else:
            why = self._wrong_number(answer)
        return why and f"{answer!r}: {why}"

    def _wrong_number(self, answer: str) -> str:
        found = read_numbers(answer, self.count, self.notation)
        if isinstance(found, str):
            return found + (f" ({self.text})" if _WITH_UNIT.fullmatch(answer.strip()) else "")
        if self.whole and any(one != round(one) for one in found):
            return "must be a whole number"
        if (smallest := min(found)) < self._least(answer):
            said = self.too_small(smallest) if self.too_small else ""
            return said or f"must not be below {self.least:g}"
        return f"must not be above {self.most:g}" if max(found) > self.most else ""

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
