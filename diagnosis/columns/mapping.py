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
`name=column*factor+offset`, `name=0.2`, `rate_hz=50`, `separator=tab`, `decimal=,`).
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Sequence
from collections.abc import Mapping as AnyMapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator

from diagnosis.columns.doubts import doubt, of_counts
from diagnosis.columns.names import (
    LINEAR,
    PULLING,
    ROTARY,
    SPEEDS,
    TIMES,
    UNIT_OF,
    read_name,
    unit_said,
)
from diagnosis.observations.readings import FloatArray
from foundation.errors import ConfigError, RecordingError
from foundation.explain import explain
from foundation.strict_yaml import Document, StrictModel
from recording.tables.flat import GAP_PERIODS, UNITS, AnyArray, FlatRecording, from_columns
from recording.tables.foreign_log import LOG_TIME, is_log, read_log, topic_of
from recording.tables.foreign_table import read_parquet_table, read_table

IN_SI = {
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "m": 1.0, "cm": 0.01, "mm": 1e-3,
    "um": 1e-6, "inch": 0.0254, "rad": 1.0, "mrad": 1e-3, "deg": np.pi / 180.0, "turn": 2.0 * np.pi,
    "arcmin": np.pi / 10800.0, "arcsec": np.pi / 648000.0,
    "N": 1.0, "mN": 1e-3, "Nm": 1.0, "mNm": 1e-3, "Ncm": 0.01, "1": 1.0, "A": 1.0, "mA": 1e-3,
    "rad/s": 1.0, "deg/s": np.pi / 180.0, "m/s": 1.0, "mm/s": 1e-3, "rpm": np.pi / 30.0,
}  # fmt: skip
"""Units by their size in the contract's."""
STANDS_IN = {
    "t": "rate_hz (rows are evenly spaced), or any time column with its unit",
    "command": "effort, with `inertia` in the robot file",
    "effort": "command",
    "position": "theta_1",
    "theta_1": "position",
    "steps_1": "command_1 (rad at the arm)",
    "command_1": "steps_1, with `drive` in the robot file",
    "distance": "a constant (`distance=0.2`), if the target stood still",
}
OF_THE_TABLE = ("rate_hz", "skip_lines", "heading", "separator", "decimal")
"""What `--set` takes beside columns; separators also by name: tab, space, comma, semicolon."""
_OPTION = re.compile(
    r"(?P<name>\w+)=(?P<from>[^*+]+?)(\[(?P<unit>\w+|(rad|deg|m|mm)/s)\])?"
    r"(\*(?P<scale>[-+]?[.\d]+([eE][-+]?\d+)?))?"
    r"(?P<offset>[+-][.\d][.\deE+-]*)?"
)


A_FACTOR = "or a factor to SI units in its place, as position=seen*4.848e-6"


def no_unit(said: str) -> str:
    """Why a unit is refused, and which was meant by it: as people write it, or nearly."""
    meant = UNIT_OF.get(said.lower()) or next(
        iter(difflib.get_close_matches(said, IN_SI, n=1, cutoff=0.6)), None
    )
    if meant in IN_SI:
        return f"unknown unit '{said}'; did you mean '{meant}'?"
    return f"unit must be one of {', '.join(IN_SI)}, {A_FACTOR}"


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
    separator: Annotated[str, Field(min_length=1, max_length=1)] = ","
    """A space stands for any run of spaces and tabs."""
    decimal: Literal[".", ","] = "."
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
    return {"tab": "\t", "space": " ", "comma": ",", "semicolon": ";"}.get(text, text)


def read_mapped(
    path: Path, mapping: Mapping, tell: Callable[[str], None] = lambda _: None
) -> FlatRecording:
    """Read a table or a log through a mapping; columns that it does not name keep theirs.

    tell: takes a sentence for each unit that nobody gave and the heading says.
    Raises RecordingError that says which column is missing and what could stand for it.
    """
    table = _table(path, mapping)
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
    for name, values in table.items():
        if name not in used and name not in named:
            named[name] = values
    if "t" not in named and mapping.rate_hz is not None:
        named["t"] = np.arange(rows) / mapping.rate_hz
    if "t" not in named:
        raise _missing(path, "t", "t", list(table))
    t_s = _going_on(named.pop("t"), named.get("segment"))
    return from_columns({"t": t_s, **named}, str(path))


def _table(path: Path, mapping: Mapping) -> dict[str, AnyArray]:
    """The file's own columns: of a log, a Parquet file, or any text with separators."""
    if is_log(path):
        sources = [mapping.columns[name].from_ for name in ("t", *mapping.columns)
                   if name in mapping.columns]  # fmt: skip
        topics = [topic_of(source) for source in sources if source is not None]
        table = read_log(path, next(filter(None, topics), None))
        return table if "t" in mapping.columns else {"t": table[LOG_TIME], **table}
    if path.suffix == ".parquet":
        return read_parquet_table(path)
    try:
        return read_table(
            path, mapping.skip_lines, mapping.heading, mapping.separator, mapping.decimal
        )
    except RecordingError as error:
        raise RecordingError(
            f"{error}; how it can be read: deltactl diagnose --inspect {path}"
        ) from None


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
    """The column of this name, or the only one called so before a unit in brackets.

    Raises RecordingError that lists what is there.
    """
    assert source.from_ is not None
    if source.from_ in table:
        return source.from_
    alike = [column for column in table if without_unit(column) == source.from_]
    if len(alike) != 1:
        raise _missing(path, name, source.from_, list(table))
    return alike[0]


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


def without_unit(name: str) -> str:
    """A column's name without a unit in brackets at its end."""
    return re.sub(r"\s*[\[(][^\])]*[\])]\s*$", "", name)


FEW_LETTERS = 3
"""What is shorter stands in many a name."""


def _missing(path: Path, name: str, wanted: str, there: list[str]) -> RecordingError:
    other = STANDS_IN.get(name)
    if name == "theta_1" and any(map(_of_further_motor, there)):
        other = None  # a lone position tells nothing of three arms
    near = [one for one in there if len(wanted) >= FEW_LETTERS and wanted.lower() in one.lower()]
    near += difflib.get_close_matches(wanted, [without_unit(one) for one in there], n=1, cutoff=0.6)
    way = f"; {other} could stand for it" if other else ""
    way = f"; did you mean '{near[0]}'?" if near else way
    plain = without_unit(wanted)
    if plain != wanted and plain in there:
        unit = wanted[len(plain) :].strip().strip("[]()")
        return RecordingError(
            f"{path}: --set {name}={wanted}: the unit '{unit}' is not known; it must be one of"
            f" {', '.join(IN_SI)}, {A_FACTOR}"
        )
    of = f" (for {name})" if wanted != name else ""
    return RecordingError(
        f"{path}: column '{wanted}'{of} is missing{way}; the table has {', '.join(there)[:200]}"
    )


def _of_further_motor(column: str) -> bool:
    """Whether a column is called as that of a second or third motor, as q2."""
    named = read_name(column)
    return named.index in ("2", "3") and named.role in ("command", "position", "steps")


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
    try:
        return Source(value=float(match["from"]) * scale * IN_SI[unit] + offset)
    except ValueError:
        return Source.model_validate({"from": match["from"].strip(), "offset": offset, **given})


def _number(text: str, option: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ConfigError(f"--set {option}: '{text}' is not a number") from None
