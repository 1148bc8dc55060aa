"""Why a call has no answer, in parts: an assistant acts on kind and column, not on prose."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

from pydantic import ValidationError

from deltactl.foundation.errors import (
    ConfigError,
    DeltactlError,
    ForbiddenPath,
    MissingExtra,
    MissingFile,
    RefusedRecording,
    ServiceError,
)
from deltactl.recording.tables.flat import UNITS

KINDS: tuple[tuple[type[BaseException], str], ...] = (
    (ForbiddenPath, "path"),
    (MissingFile, "missing_file"),
    (MissingExtra, "not_installed"),
    (ServiceError, "not_finished"),
)
"""What is refused in whatever part of the work it happens; the first that fits."""
INSPECT = "call inspect on the file, and pass its columns to diagnose"
INSTEAD = {
    "arguments": "call the tool as its schema says",
    "columns": INSPECT,
    "defect": "tell the user that deltactl failed, and that its log on standard error says more",
    "not_finished": "try again, or give shorter recordings",
    "recording": INSPECT,
    "robot_file": "correct the robot file, or pass robot_text",
}
RECORD = {"still": "record a run in which it moves", "short": "record a longer run"}
"""What to do about recordings that hold too little, whatever else is said of them."""
"""What to do where a message does not say it."""
WORDS = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
NAMED = re.compile(r"""'([^']+)'|(?:\bcolumns? |--set "?)([A-Za-z_][A-Za-z_0-9]*)""")
"""A column in a message: quoted, behind "column", or the first part of an option."""


@dataclass(frozen=True, slots=True)
class Refused:
    """Why a call has no answer.

    kind: `path`, `missing_file`, `arguments`, `columns`, `robot_file`, `recording`,
    `not_installed`, `not_finished`, `unknown_name` or `defect`, or one of the kinds of the
    diagnosis (`diagnosis.admission.refusal.Kind`). column: the column or argument that it is about;
    empty where it is about no single one.
    """

    kind: str
    why: str
    do: str
    column: str = ""
    where: str = ""
    """The recording, and the first row or time at which it is wrong."""

    def to_json(self) -> dict[str, Any]:
        """Its parts as an answer carries them."""
        return {"refused": asdict(self)}

    @property
    def text(self) -> str:
        """The same in words."""
        about = f", column {self.column}" if self.column else ""
        where = f"{self.where}: " if self.where else ""
        return f"Refused ({self.kind}{about}). {where}{self.why}. What to do: {self.do}."


def refused(error: BaseException, part: str, columns: Iterable[str] = ()) -> Refused:
    """The refusal of an error.

    Parameters
    ----------
    part : str
        The kind of those that are of no kind by themselves: `robot_file`, `columns`, `recording`.
    columns : iterable of str, optional
        Names of columns that the message may be about, beside those of the program.
    """
    if isinstance(error, RefusedRecording) and error.refusal is not None:
        refusal = error.refusal
        row = f"row {refusal.row}" if refusal.row is not None else ""
        time = f"t = {refusal.t_s:g} s" if refusal.t_s is not None else ""
        where = ", ".join(filter(None, [refusal.source, row, time]))
        column = refusal.column.removeprefix("the ") or _column(refusal.why, columns)
        kind = str(refusal.kind)
        why, do = _divided(refusal.why, refusal.remedy)
        return Refused(kind, why, RECORD.get(kind, do), column, where)
    if not isinstance(error, DeltactlError | OSError | ModuleNotFoundError):
        why = f"deltactl itself failed ({type(error).__name__})"
        return Refused("defect", why, INSTEAD["defect"])
    kind = next((name for known, name in KINDS if isinstance(error, known)), part)
    mistakes = error.args if isinstance(error, ConfigError) and error.args else (error,)
    first = " ".join(str(mistakes[0]).split())
    why, _, do = first.rpartition("; ")
    why, do = (why, do) if why else (do, INSTEAD.get(kind, INSTEAD["arguments"]))
    column = _column(first, columns) if kind in ("columns", "recording") else ""
    kind = "columns" if column else kind
    return Refused(kind, _plain(why), _plain(do), column)


def refused_arguments(tool: str, error: ValidationError, names: Iterable[str]) -> Refused:
    """The refusal of arguments that do not fit the schema of a tool, which has these names."""
    first = error.errors(include_url=False, include_input=False)[0]
    where = ".".join(map(str, first["loc"]))
    what = first["msg"].removeprefix("Value error, ")
    name = str(first["loc"][0]) if first["loc"] else ""
    name = name or next((one for one in WORDS.findall(what) if one in names), "")
    why = f"{tool}: {where or 'the arguments'}: {what}"
    return Refused("arguments", _plain(why), INSTEAD["arguments"], name)


def _divided(why: str, remedy: str) -> tuple[str, str]:
    """What is wrong and what to do, where a remark in brackets is in the place of a remedy."""
    if remedy and not remedy.startswith("("):
        return _plain(why), _plain(remedy)
    what, _, do = why.partition(". ")
    return _plain(f"{what} {remedy}"), _plain(do) or INSPECT


def _column(message: str, columns: Iterable[str]) -> str:
    """The column that a message names first: one of the file, or one that the program knows.

    A name that is an English word too counts where it is quoted, or behind "column".
    """
    known = {*columns, *UNITS}
    names = [quoted or behind for quoted, behind in NAMED.findall(message)]
    plain = [one for one in WORDS.findall(message) if "_" in one]
    return next((one for one in [*names, *plain] if one in known), "")


def _plain(text: str) -> str:
    """One line without a full stop, which the sentence around it has; options as arguments."""
    if "deltactl inspect " in text:
        return INSPECT
    return " ".join(text.split()).rstrip(".").replace("--set ", "columns ")
