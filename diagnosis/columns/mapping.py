"""Tables of others: their column names and units, brought to those of the contract.

A mapping says for each contract column where it comes from:

    columns:
      t: {from: time_ms, scale: 0.001}
      position: {from: angle, unit: deg}
      distance: {value: 0.2}            # the same in every row
    rate_hz: 50                         # instead of t: one row every 1/50 s
    skip_lines: 3                       # lines before the heading
    heading: [d]                        # names of the columns, where the file has none
    separator: ";"
    decimal: ","

On the command line the same is `--set t=time_ms*0.001 --set "position=angle[deg]"` (also
`name=column*factor+offset`, `name=0.2`, `rate_hz=50`, `separator=tab`, `decimal=,`). A column
whose name holds a star, or ends like an offset, stands in quotes: `--set 'position="axis-1"'`.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Collection, Iterable, Sequence
from collections.abc import Mapping as AnyMapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator

from diagnosis.columns.doubts import doubt, of_counts
from diagnosis.columns.missing import no_column, no_time, other_separator
from diagnosis.columns.names import (
    IN_SI,
    LINEAR,
    PULLING,
    ROTARY,
    SPEEDS,
    TIMES,
    Guess,
    no_unit,
    unit_said,
    without_unit,
)
from diagnosis.observations.readings import FloatArray
from foundation.errors import ConfigError, RecordingError
from foundation.explain import explain
from foundation.strict_yaml import Document, StrictModel
from recording.tables.cell import number
from recording.tables.flat import GAP_PERIODS, UNITS, AnyArray, FlatRecording, from_columns
from recording.tables.foreign_log import LOG_TIME, is_log, read_log, topic_of
from recording.tables.foreign_table import is_parquet, read_parquet_table, read_table
from recording.tables.table_format import IN_OPTIONS, guess_marks, marks_said

MOVING = frozenset(
    name for name in UNITS if name.split("_")[0] in ("command", "steps", "theta", "pos", "position")
)
"""What is asked of machines that move, and comes of it."""
OF_THE_TABLE = ("rate_hz", "skip_lines", "heading", "separator", "decimal")
"""What `--set` takes beside columns; separators also by name: tab, space, comma, semicolon."""
_OPTION = re.compile(
    r"(?P<name>\w+)=(?:\"(?P<quoted>[^\"]+)\"|(?P<from>[^*+]+?))"
    r"(\[(?P<unit>(?!\d+\])\w+|(rad|deg|m|mm)/s)\])?"
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
    """What is added to them then, in the unit of the column that it becomes."""
    unit: str = "1"
    """The unit of its numbers; 1: that of the column that it becomes."""
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
    """Each column that the program knows, by name, and where it comes from."""
    rate_hz: Annotated[float, Field(gt=0.0)] | None = None
    """Rows a second, of a table without times."""
    skip_lines: Annotated[int, Field(ge=0)] = 0
    """So many lines before the heading are not read."""
    heading: tuple[str, ...] = ()
    """Names of the columns, of a table that has no line of them."""
    separator: Annotated[str, Field(min_length=1, max_length=1)] | None = None
    """A space stands for any run of spaces and tabs; without it, what makes the cells numbers."""
    decimal: Literal[".", ","] | None = None
    """What stands before the decimals of a number."""

    @model_validator(mode="after")
    def _known(self) -> Mapping:
        for name in self.columns:
            if name not in UNITS:
                raise ValueError(f"columns: '{name}' must be one of {', '.join(UNITS)}")
        return self


def load_mapping(path: Path | None, options: Sequence[str] = ()) -> Mapping:
    """A mapping file with `--set` options laid over it. Raises ConfigError or MissingFile."""
    mapping = Mapping() if path is None else Document.read(path).check(Mapping)
    columns, changes = dict(mapping.columns), dict[str, Any]()
    for option in options:
        name, _, rest = option.partition("=")
        if name in OF_THE_TABLE:
            changes[name] = _of_the_table(name, rest, option)
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


def read_mapped(
    path: Path, mapping: Mapping, tell: Callable[[str], None] = lambda _: None
) -> FlatRecording:
    """Read a table or a log through a mapping; columns that it does not name keep theirs.

    tell: takes a sentence for whatever was found in the file and nobody said: a separator other
    than the comma, a unit in a heading. Raises RecordingError that says which column is missing
    and what could stand for it.
    """
    table = _table(path, mapping, tell)
    rows = len(next(iter(table.values())))
    named: dict[str, FloatArray] = {}
    used: set[str] = set()
    for name, source in mapping.columns.items():
        if source.value is not None:
            named[name] = np.full(rows, source.value)
            continue
        column = named_column(path, table, name, source)
        used.add(column)
        unit = unit_of(path, column, name, source)
        if IN_SI[unit] != IN_SI[source.unit]:
            tell(f"{path.name}: {name} is read in {unit}, as the heading '{column}' says")
        if "scale" not in source.model_fields_set:
            if why := of_counts(name, column, unit, table[column]):
                raise RecordingError(f"{path}: {why}")
            if why := doubt(name, column, unit, table[column]):
                tell(f"{path.name}: {why}")
        factor = source.scale * IN_SI[unit]
        named[name] = table[column] * factor + source.offset
    timed = "t" in named or mapping.rate_hz is None
    for name, values in table.items():
        if name not in used and name not in named and (timed or name != "t"):
            named[name] = values
    if "t" not in named:
        rate_hz = mapping.rate_hz or _without_times(path, set(named), list(table), tell)
        named["t"] = np.arange(rows) / rate_hz
    t_s = _going_on(named.pop("t"), named.get("segment"))
    return from_columns({"t": t_s, **named}, str(path))


def _without_times(
    path: Path, named: set[str], there: list[str], tell: Callable[[str], None]
) -> float:
    """Rows per second of a table that says none: one, of a ranging sensor beside a ruler.

    Raises RecordingError where times are needed.
    """
    if not needs_no_times(named):
        raise no_time(path, there)
    tell(f"{path.name}: has no times, and a ranging sensor needs none: rows count as one a second")
    return 1.0


def needs_no_times(named: Collection[str]) -> bool:
    """Whether columns are those of a ranging sensor alone, of which every row stands for itself."""
    return {"distance", "range"} <= set(named) and not MOVING & set(named)


def _table(path: Path, mapping: Mapping, tell: Callable[[str], None]) -> dict[str, AnyArray]:
    """The file's own columns: of a log, a Parquet file, or any text with separators."""
    if is_log(path):
        sources = [mapping.columns[name].from_ for name in ("t", *mapping.columns)
                   if name in mapping.columns]  # fmt: skip
        topics = [topic_of(source) for source in sources if source is not None]
        table = read_log(path, next(filter(None, topics), None))
        return table if "t" in mapping.columns else {"t": table[LOG_TIME], **table}
    if is_parquet(path):
        return read_parquet_table(path)
    separator, decimal = _marks(path, mapping, tell)
    other = other_separator(path, mapping.separator)
    try:
        table = read_table(
            path, mapping.skip_lines, mapping.heading, separator, decimal,
            tell=lambda words: tell(f"{path.name}: {words}"),
        )  # fmt: skip
    except RecordingError as error:
        if other:
            raise RecordingError(f"{path}: {other}") from None
        raise RecordingError(
            f"{error}; how it can be read: deltactl diagnose --inspect {path}"
        ) from None
    if other and len(table) == 1:
        raise RecordingError(f"{path}: {other}")
    return table


def _marks(path: Path, mapping: Mapping, tell: Callable[[str], None]) -> tuple[str, str]:
    """Separator and decimal mark: as they are said, else as the file shows them."""
    if mapping.separator is not None and mapping.decimal is not None:
        return mapping.separator, mapping.decimal
    try:
        marks = guess_marks(path, mapping.separator, mapping.decimal)
    except RecordingError:  # which whoever reads the cells says better
        return mapping.separator or ",", mapping.decimal or "."
    if marks != (mapping.separator or ",", mapping.decimal or "."):
        tell(f"{path.name}: is read with {marks_said(*marks)}")
    return marks


def _going_on(t_s: FloatArray, segment: FloatArray | None) -> FloatArray:
    """Times that start again with every segment, laid one behind the other with a gap between."""
    if segment is None or len(t_s) < 3:
        return t_s
    step = np.diff(t_s)
    back = (step <= 0.0) & (np.diff(segment) != 0.0)
    gap = 2.0 * GAP_PERIODS * float(np.median(step))
    shift = np.concatenate([[0.0], np.cumsum(np.where(back, gap - step, 0.0))])
    going_on: FloatArray = t_s + shift
    return going_on


def named_column(path: Path, table: AnyMapping[str, AnyArray], name: str, source: Source) -> str:
    """The column of this name, the only one called so before a unit in brackets, or the one at a
    place among joints with names (action.2).

    Raises RecordingError that lists what is there.
    """
    assert source.from_ is not None
    if source.from_ in table:
        return source.from_
    alike = [column for column in table if without_unit(column) == source.from_]
    alike = alike or _at_place(table, source.from_)
    if len(alike) != 1:
        raise no_column(path, name, source.from_, list(table))
    return alike[0]


def _at_place(table: Iterable[str], wanted: str) -> list[str]:
    """The column that `stem.2` means where the columns of a stem are called otherwise."""
    stem, _, place = wanted.rpartition(".")
    of_stem = [column for column in table if column.startswith(f"{stem}.")]
    return of_stem[int(place) : int(place) + 1] if stem and place.isdecimal() else []


def unit_of(path: Path, column: str, name: str, source: Source) -> str:
    """The unit that was given; else the one that the heading says.

    Raises RecordingError where both are said and are not the same. A factor that was given, 1 too,
    is taken as it stands.
    """
    heading = unit_said(column, name)
    if "scale" in source.model_fields_set:
        return source.unit
    if "unit" not in source.model_fields_set:
        return heading or "1"
    if heading is not None and _contradict(heading, source.unit):
        plain = without_unit(column)
        raise RecordingError(
            f"{path}: {name} is given in {source.unit}, and the heading '{column}' says {heading};"
            f' type --set "{name}={plain}[{heading}]", or, where the heading is wrong,'
            f' --set "{name}={plain}[{source.unit}]*1"'
        )
    return source.unit


def _contradict(heading: str, given: str) -> bool:
    """Whether two units differ in size; a single letter (theta_m: of the motor) may be no unit."""
    if IN_SI[heading] == IN_SI[given]:
        return False
    alike = any(heading in units and given in units for units in (TIMES, ROTARY, LINEAR, PULLING))
    return alike or len(heading) > 1


def against_heading(guess: Guess) -> bool:
    """Whether a column is taken in another unit than its heading says, which needs a factor."""
    heading = unit_said(guess.source, guess.name)
    return None not in (heading, guess.unit) and _contradict(heading or "1", guess.unit or "1")


def _source(option: str) -> Source:
    match = _OPTION.fullmatch(option.strip())
    if match is None or match["name"] not in UNITS:
        names = (*OF_THE_TABLE, *UNITS)
        wanted = option.partition("=")[0].strip()
        near = [] if wanted in names else difflib.get_close_matches(wanted, names, n=1)
        near = [one for one in names if one == f"{wanted}_1"] or near  # the first motor's
        meant = f" (did you mean {near[0]}?)" if near else ""
        raise ConfigError(
            f"--set {option}: must be NAME=COLUMN, NAME=COLUMN[unit], NAME=COLUMN*FACTOR+OFFSET or "
            f"NAME=VALUE with NAME one of {', '.join(names)}{meant}"
        )
    unit = match["unit"] or "1"
    if unit not in IN_SI:
        raise ConfigError(f"--set {option}: {no_unit(unit)}")
    if unit in SPEEDS and match["name"] != "velocity":
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


def as_option(name: str, column: str, unit: str, scale: float | None, offset: float) -> str:
    """What `--set` takes for a column; scale: None where no factor was given."""
    unit = f"[{unit}]" if IN_SI[unit] != 1.0 else ""
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
