"""Tables of others: their column names and units, brought to those of the contract.

A mapping says for each contract column where it comes from:

    columns:
      t: {from: time_ms, scale: 0.001}
      position: {from: angle, unit: deg}
      distance: {value: 0.2}            # the same in every row
    unit: mm                            # of the axis' columns that neither this nor a heading says
    rate_hz: 50                         # instead of t: one row every 1/50 s
    skip_lines: 3                       # lines before the heading
    heading: [d]                        # names of the columns, where the file has none
    separator: ";"
    decimal: ","

On the command line the same is `--set t=time_ms*0.001 --set "position=angle[deg]"` (also
`name=column*factor+offset`, `name=0.2`, `unit=mm`, `rate_hz=50`, `separator=tab`, `decimal=,`;
`effort=` leaves a column out; `theta=q_{0..5}` or `theta={base,elbow}.pos` are theta_1, theta_2
and so on, of a chain). A column whose name holds a star, or ends like an offset, is put in
quotes: `--set 'position="axis-1"'`.
"""

from __future__ import annotations

import difflib
import itertools
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, model_validator

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.explain import explain
from deltactl.foundation.strict_yaml import Document, StrictModel
from deltactl.recording.foreign.units import (
    IN_SI,
    LINEAR,
    ROTARY,
    SPEEDS,
    UNIT_APART,
    no_unit,
    of_motion,
)
from deltactl.recording.tables.cells import number
from deltactl.recording.tables.flat import UNITS, known_unit
from deltactl.recording.tables.table_format import IN_OPTIONS, WIDE

OF_THE_TABLE = ("unit", "rate_hz", "skip_lines", "heading", "separator", "decimal")
"""What `--set` takes beside columns; separators also by name: tab, space, spaces, comma,
semicolon."""
BARE = ("rad", "m", "rad/s", "m/s")
"""Units of the contract that are written all the same, as others may be meant; s and N are not."""
_OPTION = re.compile(
    r"(?P<name>\w+)=(?:\"(?P<quoted>[^\"]+)\"|(?P<from>[^*+]+?))"
    r"(\[(?P<unit>(?!\d+\])\w+|(rad|deg|turn|m|mm)/s)\])?"
    r"(\*(?P<scale>[-+]?[.\d]+([eE][-+]?\d+)?))?"
    r"(?P<offset>[+-][.\d][.\deE+-]*)?"
)


class Source(StrictModel):
    """One column: from where, in which unit, times what, plus what; or one value for all rows."""

    from_: Annotated[str | None, Field(alias="from")] = None
    """The column's name in the table; or give `value`."""
    scale: float = 1.0
    """What its numbers are multiplied by, beside their unit."""
    offset: float = 0.0
    """What is added then, in the unit of the new column."""
    unit: str = "1"
    """The unit of its numbers; 1: that of the new column."""
    value: float | None = None
    """The same in all rows, in place of a column."""

    @model_validator(mode="after")
    def _either(self) -> Source:
        if (self.from_ is None) == (self.value is None):
            raise ValueError("needs either `from` or `value`")
        if self.unit not in IN_SI:
            raise ValueError(no_unit(self.unit))
        return self


class Mapping(StrictModel):
    """How a table of someone else becomes a recording."""

    columns: dict[str, Source] = Field(default_factory=dict)
    """Each column by its name, and where it comes from."""
    unit: str | None = None
    """Unit of an axis' motion where no heading says one."""
    rate_hz: Annotated[float, Field(gt=0.0)] | None = None
    """Rows a second, of a table without times."""
    skip_lines: Annotated[int, Field(ge=0)] = 0
    """So many lines before the heading are not read."""
    heading: tuple[str, ...] = ()
    """Names of the columns, of a table that has no line of them."""
    separator: Annotated[str, Field(min_length=1, max_length=2)] | None = None
    """A space means any run of spaces and tabs, two spaces two or more."""
    decimal: Literal[".", ","] | None = None
    """The decimal mark."""
    leave_out: tuple[str, ...] = ()
    """Columns that are not read."""

    @model_validator(mode="after")
    def _known(self) -> Mapping:
        for name in (*self.columns, *self.leave_out):
            if known_unit(name) is None:
                where = "columns" if name in self.columns else "leave_out"
                raise ValueError(f"{where}: '{name}' must be one of {', '.join(UNITS)}")
        if self.unit is not None:
            _refuse_unit(self.unit)
        if self.separator is not None and len(self.separator) > 1 and self.separator != WIDE:
            raise ValueError("separator: must be one character, or two spaces")
        return self


def _refuse_unit(unit: str) -> None:
    """Raise ValueError for what is neither a unit of a motion nor a number."""
    size = number(unit)
    if unit not in (*ROTARY, *LINEAR) and not (size is not None and size > 0.0):
        if UNIT_APART.get(unit.lower()) in (*ROTARY, *LINEAR):
            raise ValueError(f"unit: {no_unit(unit)}")
        known = of_motion(ROTARY, LINEAR)
        raise ValueError(f"unit: '{unit}' must be {known}; or what one is in rad or m")


_OF_JOINTS = re.compile(r"(theta|command|velocity|effort)=([^{}]*)\{([^{}]+)\}([^{}]*)")
_FROM_TO = re.compile(r"(\d+)\.\.(\d+)")
_OF_ONE = re.compile(r"(theta|command|velocity|effort)_(\d+)=([^{},]*)")


def each_joint(option: str) -> list[str]:
    """The options of all joints for one with braces; another as it is."""
    if (match := _OF_JOINTS.fullmatch(option)) is None:
        return [option]
    name, before, inner, after = match.groups()
    ends = _FROM_TO.fullmatch(inner)
    parts = [*map(str, range(int(ends[1]), int(ends[2]) + 1))] if ends else inner.split(",")
    return [f"{name}_{n}={before}{part}{after}" for n, part in enumerate(parts, 1)]


def joints_together(options: Sequence[str]) -> list[str]:
    """Options of several joints as one with braces, as far as `each_joint` gives them back."""
    made: list[str] = []
    for name, group in itertools.groupby(options, lambda one: one.partition("_")[0]):
        own = list(group)
        matches = [match for one in own if (match := _OF_ONE.fullmatch(one))]
        short = _in_braces(name, [match[3] for match in matches]) if len(matches) > 1 else ""
        made += [short] if short and each_joint(short) == own else own
    return made


def _in_braces(name: str, columns: list[str]) -> str:
    start = _alike(columns)
    end = _alike([one[start:][::-1] for one in columns])
    before, after = columns[0][:start], columns[0][len(columns[0]) - end :]
    parts = [one[start : len(one) - end] for one in columns]
    numbers = [int(part) for part in parts if part.isdecimal()]
    row = range(numbers[0], numbers[-1] + 1) if numbers else []
    inner = f"{parts[0]}..{parts[-1]}" if numbers == [*row] and row else ",".join(parts)
    return f"{name}={before}{{{inner}}}{after}"


def _alike(texts: Sequence[str]) -> int:
    """So many letters at the beginning of each are the same."""
    differing = (n for n, letters in enumerate(zip(*texts, strict=False)) if len({*letters}) > 1)
    return next(differing, min(map(len, texts)))


def load_mapping(path: Path | None, options: Sequence[str] = ()) -> Mapping:
    """A mapping file with `--set` options laid over it. Raises ConfigError or MissingFile."""
    mapping = Mapping() if path is None else Document.read(path).check(Mapping)
    columns, changes = dict(mapping.columns), dict[str, Any]()
    for option in itertools.chain.from_iterable(map(each_joint, options)):
        name, equals, rest = option.partition("=")
        if name in OF_THE_TABLE:
            changes[name] = _of_the_table(name, rest, option)
        elif equals and not rest and known_unit(name) is not None and name != "t":
            changes["leave_out"] = (*changes.get("leave_out", mapping.leave_out), name)
            columns.pop(name, None)
        else:
            columns[name] = _source(option)
    try:
        return Mapping.model_validate(mapping.model_dump() | changes | {"columns": columns})
    except ValidationError as error:
        _, message = explain(Mapping, error, ())
        raise ConfigError(f"--set: {message}") from None


def _of_the_table(name: str, text: str, option: str) -> Any:
    if name == "rate_hz":
        return _number(text, option)
    if name == "skip_lines":
        return round(_number(text, option))
    if name == "heading":
        return tuple(part.strip() for part in text.split(","))
    marks = {called: mark for mark, called in IN_OPTIONS.items()}
    return marks.get(text, text)


def _source(option: str) -> Source:
    match = _OPTION.fullmatch(option.strip())
    if match is None or known_unit(match["name"]) is None:
        raise _not_understood(option)
    unit = match["unit"] or "1"
    if unit not in IN_SI:
        raise ConfigError(f"--set {option}: {no_unit(unit)}")
    if unit in SPEEDS and not match["name"].startswith("velocity"):
        raise ConfigError(f"--set {option}: {unit} is a unit of velocity, not of {match['name']}")
    given: dict[str, Any] = {} if match["unit"] is None else {"unit": unit}
    scale = 1.0
    if match["scale"] is not None:
        given["scale"] = scale = _number(match["scale"], option)
    offset = 0.0 if match["offset"] is None else _number(match["offset"], option)
    named = match["quoted"] or match["from"].strip()
    if match["quoted"] is None and (value := number(named)) is not None:
        return Source(value=value * scale * IN_SI[unit] + offset)
    return Source.model_validate({"from": named, "offset": offset, **given})


def _not_understood(option: str) -> ConfigError:
    """The error of an option that is none, with the name that was meant."""
    names = (*OF_THE_TABLE, *UNITS)
    wanted = option.partition("=")[0].strip()
    near = [] if wanted in names else difflib.get_close_matches(wanted, names, n=1)
    near = [name for name in names if name == f"{wanted}_1"] or near  # the first motor's
    if owed := re.search(r"\*([A-Z][A-Z_]+)$", option):
        return ConfigError(
            f"--set {option}: put a number for {owed[1]}; deltactl inspect FILE says which"
        )
    longer = [name for name in names if wanted and wanted not in names and name.startswith(wanted)]
    near = sorted(longer, key=lambda name: name[-2:-1] == "_") or near  # those without a number
    meant = f"{wanted} is no name here; did you mean {near[0]}? It " if near else ""
    return ConfigError(
        f"--set {option}: {meant}must be NAME=COLUMN, NAME=COLUMN[unit],"
        f" NAME=COLUMN*FACTOR+OFFSET or NAME=VALUE with NAME one of {', '.join(names)}"
    )


def as_option(name: str, column: str, unit: str, scale: float | None, offset: float) -> str:
    """What `--set` takes for a column; scale: None where no factor was given."""
    stated = IN_SI[unit] != 1.0 or (scale in (None, 1.0) and unit in BARE)
    unit = f"[{unit}]" if stated else ""
    factor = "" if scale is None else f"*{scale:.12g}"
    further = f"{unit}{factor}{f'{offset:+.12g}' if offset else ''}"
    bare = f"{name}={column}{further}"
    match = _OPTION.fullmatch(bare)
    plain = match is not None and match["from"] == column and number(column) is None
    return bare if plain else f'{name}="{column}"{further}'


def _number(text: str, option: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ConfigError(f"--set {option}: '{text}' is not a number") from None
