"""What was found in a table of somebody else, and the options and the file that read it."""

from __future__ import annotations

import html
import shlex
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from deltactl.foundation.errors import RecordingError
from deltactl.recording.foreign.mapping import Mapping, Source, as_option
from deltactl.recording.foreign.motion_units import Asked
from deltactl.recording.foreign.names import (
    Factor,
    Guess,
    may_be_outside,
    of_role,
    pulls,
    read_name,
    unit_said,
    without_unit,
)
from deltactl.recording.foreign.notes import Hint, not_about
from deltactl.recording.foreign.shapes import repeats
from deltactl.recording.foreign.units import IN_SI, LONE
from deltactl.recording.reading.run import FloatArray
from deltactl.recording.tables.table_format import IN_OPTIONS

KEPT = "kept, not used"
"""Words for a column that nothing speaks for or against."""
INIT = {
    "delta": ("delta",),
    "servo_axis": ("axis",),
    "stepper_axis": ("axis", "--drive", "stepper"),
    "range_sensor": ("sensor",),
    "chain": ("chain", "--model", "MODEL.urdf"),
}
"""What `deltactl init` calls each kind of machine, and the options that kind needs."""


def init_words(kind: str, file: str) -> list[str]:
    """The words behind `deltactl` that describe a machine of this kind in a file."""
    name, *options = INIT[kind]
    return ["init", name, file, *options]


def robot_named_after(table: Path) -> str:
    """The robot file of the machine of a table, without its ending."""
    return f"{Path(table.name.removesuffix('.gz')).stem}-robot"


def diagnosing(paths: Sequence[Path], robot: str, read: Sequence[str]) -> list[str]:
    """The command that diagnoses files together, as words; read: the options that read them."""
    return ["deltactl", "diagnose", *map(str, paths), "--robot", robot, *read]


@dataclass(frozen=True, repr=False)
class Inspection:
    """What was found in one file."""

    path: Path
    facts: list[tuple[str, str]]
    """How the file is written, and its times: name and words."""
    table: dict[str, FloatArray]
    guesses: dict[str, Guess]
    """By the column's name in the file; columns without one are kept, and not used."""
    kind: str | None
    motion: str | None
    """linear or rotary, of a servo axis; None where it is not known."""
    kind_why: str
    zero: str | None
    """arbitrary where the readings are far from the commands; None where that is not known."""
    mapping: Mapping
    warnings: list[str] = field(default_factory=list)
    counter: str | None = None
    """A column that counts the rows, where no times are needed."""

    stumbles: str | None = None
    """A column of times that does not increase in every row."""
    own_run: bool = False
    """Whether the program itself recorded it."""
    asked: Asked | None = None
    """The unit that its owner has to say, of an axis."""
    named: bool = True
    """Whether the file names its columns; where not, they are called by their place."""

    @property
    def needs_inertia(self) -> bool:
        """Whether nothing but an effort says what moves the axis."""
        there = {guess.name for guess in self.guesses.values()}
        return self.kind == "servo_axis" and "effort" in there and "command" not in there

    def unused(self, column: str) -> str:
        """Words for a column that is kept and not used: what it could be set to."""
        if column == self.counter:
            return "it counts the rows; a distance sensor needs no times"
        if column == self.stumbles:
            return "its times do not increase in every row"
        if column in self.table and not np.isfinite(self.table[column]).any():
            return "holds no numbers"
        if (other := self._in_another_unit(column)) is not None:
            return f"is {other} once more"
        if not pulls(column) or self.kind == "delta":
            return KEPT
        outside = may_be_outside(column) and not read_name(column).asked
        there = {guess.name for guess in self.guesses.values()}
        names = [name for name in ("load", "effort")[not outside :] if name not in there]
        example = f"{KEPT}; may be {' or '.join(names)}"
        return f"{example}: --set {names[0]}={without_unit(column)}" if names else KEPT

    def _in_another_unit(self, column: str) -> str | None:
        """The command or the reading of an axis that a column which is not used repeats."""
        used = column in self.table and read_name(column).used
        own = of_role(self.guesses, *LONE) if used else []
        return next((n for n in own if repeats(self.table[n], self.table[column])), None)

    @property
    def options(self) -> list[str]:
        """The mapping as `--set` options, empty where the file is as the contract has it. What its
        owner has to say is a word in them: UNIT, or that of a factor.

        Whoever reads the file by names of its columns finds the line of its heading by them.
        """
        said = [] if self.asked is None else ["unit=UNIT"]
        said += [f"{name}=" for name in self.mapping.leave_out]
        named = any(source.from_ for source in self.mapping.columns.values())
        left_out = ("leave_out", *(("skip_lines", "heading") if named else ()))
        for name, value in self._of_the_table().items():
            if name not in left_out:
                text = ",".join(value) if name == "heading" else IN_OPTIONS.get(value, value)
                said.append(f"{name}={text:g}" if isinstance(text, float) else f"{name}={text}")
        bare = self._unsaid
        said += [
            self._option(name, source, name in bare)
            for name, source in self.mapping.columns.items()
            if name not in bare or source.from_ != name
        ]
        return [part for one in said for part in ("--set", one)]

    @property
    def owed(self) -> RecordingError | None:
        """The error of a table whose owner has to say a unit or a number; None of another."""
        if self.asked is not None:
            how = f"it is {self.asked.units}: '{{}}' shows what to type"
            return self.misfit(f"nothing says the unit of {self.asked.named}", how)
        if not self.factors:
            return None
        words = " and ".join(f"{factor.word} ({factor.says})" for factor in self.factors.values())
        return self.misfit(f"its owner has to say {words}", "'{}' shows what to type")

    def misfit(self, why: str, how: str) -> RecordingError:
        """That the table cannot be read so, and the command that shows how, in the place of {}."""
        shows = f"deltactl inspect {shlex.quote(str(self.path))}"
        return RecordingError(f"{self.path}: {why}").with_typed(f"; {how.format(shows)}")

    @property
    def _unsaid(self) -> set[str]:
        """Columns whose unit its owner has to say."""
        guesses = (one for one in self.guesses.values() if one.name in (*LONE, "velocity"))
        return {one.name for one in guesses if self.asked is not None and one.unsaid}

    @property
    def factors(self) -> dict[str, Factor]:
        """What one of a column is, of those of which its owner has to say it."""
        return {one.name: one.factor for one in self.guesses.values() if one.factor is not None}

    def _of_the_table(self) -> dict[str, Any]:
        """What the mapping says beside columns."""
        return self.mapping.model_dump(exclude={"columns"}, exclude_defaults=True)

    def _option(self, name: str, source: Source, bare: bool) -> str:
        """What `--set` takes for a column; bare: without a unit."""
        if source.from_ is None:
            return f"{name}={source.value:.12g}"
        plain = without_unit(source.from_)
        alike = [column for column in self.table if without_unit(column) == plain]
        scale = source.scale if "scale" in source.model_fields_set else None
        where = plain if len(alike) == 1 else source.from_
        plainly = source.unit == unit_said(source.from_, name)  # which needs no saying
        unit = "1" if bare or (plainly and IN_SI[source.unit] == 1.0) else source.unit
        option = as_option(name, where, unit, scale, source.offset)
        owed = self.factors.get(name)
        return f"{option.rpartition('*')[0]}*{owed.word}" if owed else option

    @property
    def without_effort(self) -> Inspection:
        """The same table, of which no column is read as an effort."""
        columns = {name: one for name, one in self.mapping.columns.items() if name != "effort"}
        mapping = self.mapping.model_copy(update={"columns": columns})
        warnings = not_about(self.warnings, of_role(self.guesses, "effort"))
        return replace(self, mapping=mapping, warnings=warnings)

    @property
    def columns(self) -> dict[str, str]:
        """The same as `deltactl.read` takes it: column and unit by the program's own names."""
        parts = (option.partition("=") for option in self.options[1::2])
        return {name: source for name, _, source in parts}

    @property
    def in_python(self) -> list[str]:
        """The warnings for whoever types no command."""
        return [one.chosen if isinstance(one, Hint) else one for one in self.warnings]

    def __repr__(self) -> str:
        wide = max(map(len, self.table), default=0)
        lines = [f"{self.path}: {self.kind or 'unknown'} ({self.kind_why})"]
        for name in self.table:
            guess = self.guesses.get(name)
            as_what = f"{guess.name} [{guess.unit or '?'}], {guess.why}" if guess else "not used"
            lines.append(f"  {name:{wide}}  {as_what}")
        lines += [f"look here: {one}" for one in self.in_python]
        if self.kind is not None:
            lines.append(f"read it: deltactl.read({str(self.path)!r}, columns={self.columns})")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>"

    def to_json(self) -> dict[str, Any]:
        """The JSON object that `deltactl inspect --json` prints for a file."""
        return {
            "file": self.path,
            "facts": dict(self.facts),
            "kind": self.kind,
            "motion": self.motion,
            "columns": {
                name: asdict(guess) | {"name": guess.name} for name, guess in self.guesses.items()
            },
            "unused": {name: self.unused(name) for name in self.table if name not in self.guesses},
            "options": self.options,
            "warnings": self.warnings,
        }

    def mapping_text(self, typed: bool = False) -> str:
        """The mapping as a file for `--columns`; typed: with UNIT for what has to be said."""
        columns = {
            name: source.model_dump(by_alias=True, exclude_defaults=True)
            | ({"scale": source.scale} if "scale" in source.model_fields_set else {})
            for name, source in self.mapping.columns.items()
        }
        plain: dict[str, Any] = {"columns": columns}
        if typed and self.asked is not None:
            plain = {"unit": "UNIT", **plain}
            for name in self._unsaid & columns.keys():
                columns[name].pop("unit", None)
        if typed:
            for name, factor in self.factors.items():
                columns[name]["scale"] = factor.word
        for name, value in self._of_the_table().items():
            plain[name] = list(value) if isinstance(value, tuple) else value
        return yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)
