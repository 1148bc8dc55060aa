"""What the door says of a recording: refusals, which end a diagnosis, and doubts, which do not.

Their sentences are in `refusals.yaml`, by case.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache
from importlib.resources import files
from typing import Any, NoReturn

import yaml

from deltactl.foundation.errors import RefusedRecording


class Kind(StrEnum):
    """What is wrong with a recording, for whoever does not read the sentence."""

    COLUMNS = "columns"
    """A column that the diagnosis of such a machine needs is missing, or empty."""
    EMPTY = "empty"
    """A column has too few readings."""
    SHORT = "short"
    """There are too few rows, or too few of them in motion."""
    LONG = "long"
    """There are too many recordings for one diagnosis."""
    STILL = "still"
    """Nothing moves, or a reading never changes."""
    TIMES = "times"
    """The times are no seconds."""
    UNITS = "units"
    """Values in another unit than they are read in."""
    SIGN = "sign"
    """A column has the wrong sign."""
    EXCHANGED = "exchanged"
    """Two columns, motors or encoders are exchanged."""
    ROBOT_FILE = "robot_file"
    """The robot file lacks what these columns need."""
    ANOTHER_MACHINE = "another_machine"
    """The recording is of another machine than the robot file."""
    BROKEN = "broken"
    """The machine was the file's until something broke."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why a recording is not diagnosed: what is wrong, where, and what to do.

    source: the recording's name; empty where it is about all that were given. row, t_s: the first
    place at which it is wrong, where there is one.
    """

    kind: Kind
    why: str
    remedy: str = ""
    source: str = ""
    column: str = ""
    row: int | None = None
    t_s: float | None = None
    between: str = "; "
    """Between what is wrong and what to do."""

    @property
    def says(self) -> str:
        """All of it in one line."""
        where = f"{self.source}: " if self.source else ""
        remedy = f"{self.between}{self.remedy}" if self.remedy else ""
        return f"{where}{self.why}{remedy}"

    def error(self) -> RefusedRecording:
        """The same to be raised."""
        error = RefusedRecording(self.says)
        error.refusal = self
        return error

    def of(self, sources: str) -> Refusal:
        """The same, which names these recordings where it names none."""
        return self if self.source else replace(self, source=sources)


@cache
def _cases() -> Mapping[str, tuple[str, str]]:
    """Kind and sentence of every case, from `refusals.yaml`."""
    text = (files("deltactl.diagnosis.admission") / "refusals.yaml").read_text(encoding="utf-8")
    kinds = yaml.safe_load(text).items()
    return {case: (kind, says) for kind, cases in kinds for case, says in cases.items()}


def refusal(
    case: str,
    source: str = "",
    column: str = "",
    row: int | None = None,
    t_s: float | None = None,
    **values: object,
) -> Refusal:
    """The refusal of a case in `refusals.yaml`, filled in; see `Refusal`."""
    kind, says = _cases()[case]
    why, _, rest = says.partition("|")
    mark, _, remedy = rest.partition(" ")
    why, remedy = (
        text.format(source=source, column=column, t_s=t_s, **values) for text in (why, remedy)
    )
    return Refusal(Kind(kind), why, remedy, source, column, row, t_s, f"{mark} " if rest else "; ")


def refuse(case: str, source: str = "", column: str = "", **values: Any) -> NoReturn:
    """Raise it. Raises RefusedRecording."""
    raise refusal(case, source, column, **values).error()


@dataclass(frozen=True, slots=True)
class Doubt:
    """What makes an answer doubtful and refuses nothing: a sentence that is kept in the answer."""

    source: str
    column: str
    says: str


def doubt(case: str, source: str, column: str, **values: object) -> Doubt:
    """The doubt of a case in `refusals.yaml`, filled in."""
    _, says = _cases()[case]
    return Doubt(source, column, says.format(source=source, column=column, **values))
