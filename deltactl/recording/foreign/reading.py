"""A table or a log read through a mapping, with the units that its headings say."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from collections.abc import Mapping as AnyMapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.printable import count
from deltactl.recording.foreign.doubts import (
    doubt,
    far_from_readings,
    of_counts,
    of_degrees,
    of_radians,
)
from deltactl.recording.foreign.mapping import Mapping, Source
from deltactl.recording.foreign.missing import no_column, no_time, other_separator
from deltactl.recording.foreign.names import Guess, unit_said, without_unit
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.units import IN_SI, LINEAR, LONE, PULLING, ROTARY, TIMES, size_of
from deltactl.recording.reading.run import FloatArray
from deltactl.recording.tables.flat import (
    GAP_PERIODS,
    UNITS,
    AnyArray,
    FlatRecording,
    from_columns,
    known_unit,
)
from deltactl.recording.tables.foreign_log import LOG_TIME, is_log, read_log, topic_of
from deltactl.recording.tables.foreign_table import (
    ForeignTable,
    is_parquet,
    read_parquet_table,
    read_table,
)
from deltactl.recording.tables.table_format import guess_format, guess_marks, marks_said

MOVING = frozenset(
    name for name in UNITS if name.split("_")[0] in ("command", "steps", "theta", "pos", "position")
)
"""What is asked of machines that move, and comes of it."""
SAID = {"unit", "scale"}
"""What of a source says in which unit its column is."""


def read_mapped(
    path: Path, mapping: Mapping, tell: Callable[[str], None] = lambda _: None
) -> FlatRecording:
    """Read a table or a log through a mapping; columns that it does not name keep theirs.

    tell: takes a sentence for whatever was found in the file and nobody said: a separator other
    than the comma, a unit in a heading. Raises RecordingError that says which column is missing
    and what could replace it.
    """
    read = _table(path, mapping, tell)
    table, lines = read.columns, read.lines
    mapping = _in_unit(path, mapping, table)
    file = _File(path, table, lines, read.dated, tell)
    rows = len(next(iter(table.values())))
    named: dict[str, FloatArray] = {}
    used: set[str] = set()
    units: dict[str, str] = {}
    for name, source in mapping.columns.items():
        if source.value is not None:
            named[name] = np.full(rows, source.value)
            continue
        column = named_column(path, table, name, source)
        used.add(column)
        named[name] = file.read(column, name, source)
        units[name] = unit_of(path, column, name, source)
    _refuse_other_size(path, mapping, named)
    timed = "t" in named or mapping.rate_hz is None
    for name, values in table.items():
        kept = name not in used and name not in mapping.leave_out
        if kept and name not in named and (timed or name != "t"):
            named[name] = values
    counted = "t" not in named and mapping.rate_hz is None
    if "t" not in named:
        rate_hz = mapping.rate_hz or _without_times(path, set(named), list(table), tell)
        named["t"] = np.arange(rows) / rate_hz
    t_s = _going_on(named.pop("t"), named.get("segment"))
    given = [k for k, source in mapping.columns.items() if source.model_fields_set & SAID]
    recording = from_columns({"t": t_s, **named}, str(path), lines or None)
    return replace(recording, units_given=frozenset(given), units=units, timed=not counted)


def _in_unit(path: Path, mapping: Mapping, table: AnyMapping[str, AnyArray]) -> Mapping:
    """With the unit of an axis at each column of its motion of which nothing else says one."""
    if (unit := mapping.unit) is None:
        return mapping
    columns = dict(mapping.columns)
    for name in (*LONE, "velocity"):
        source = columns.get(name, Source.model_validate({"from": name}))
        own = source.from_ is None or source.model_fields_set & SAID
        if own or (name not in columns and name not in table) or name in mapping.leave_out:
            continue
        if unit_said(named_column(path, table, name, source), name) is None:
            speed = f"{unit}/s" if name == "velocity" else unit
            said = {"unit": speed} if speed in IN_SI else {"scale": size_of(unit)}
            columns[name] = source.model_copy(update=said)
    return mapping.model_copy(update={"columns": columns})


def _refuse_other_size(path: Path, mapping: Mapping, named: AnyMapping[str, FloatArray]) -> None:
    """Raise RecordingError where one distance for all rows is another unit than the readings."""
    said = mapping.columns.get("distance")
    if said is None or said.value is None or "range" not in named:
        return
    if far := far_from_readings(said.value, named["range"], mapping.columns["range"].from_):
        raise RecordingError(f"{path}: {far}")


@dataclass(frozen=True, slots=True, eq=False)
class _File:
    """A file with its own columns, the lines of its rows and the columns that are dates, whose unit
    is known, and what reports oddities in it.
    """

    path: Path
    table: AnyMapping[str, AnyArray]
    lines: Sequence[int]
    dated: Collection[str]
    tell: Callable[[str], None]

    def read(self, column: str, name: str, source: Source) -> FloatArray:
        """A column as one of the contract. Raises RecordingError where it cannot be that."""
        unit = unit_of(self.path, column, name, source)
        values = self.table[column]
        if IN_SI[unit] != IN_SI[source.unit]:
            self._say(f"{name} is read in {unit}, as the heading '{column}' says")
        if "scale" not in source.model_fields_set and column not in self.dated:
            one = name, column, unit, values
            if why := of_counts(*one):
                raise RecordingError(f"{self.path}: {why}")
            self._say(doubt(*one) or of_degrees(*one, self.table))
            self._say(of_radians(*one, self.table))
        self._say(self._gaps(column))
        return values * (source.scale * IN_SI[unit]) + source.offset

    def _say(self, words: str) -> None:
        if words:
            self.tell(f"{self.path.name}: {words}")

    def _gaps(self, column: str) -> str:
        """Which cells hold no number, where that is no habit of the log."""
        empty = np.flatnonzero(np.isnan(self.table[column]))
        if not 0 < len(empty) < GUESSES.seldom_empty * len(self.table[column]):
            return ""
        first, many = int(empty[0]), len(empty) > 1
        place = f"line {self.lines[first]}" if self.lines else f"row {first + 1}"
        hold, where = ("hold", f"the first in {place}") if many else ("holds", place)
        cells = count(len(empty), "cell")
        return f"read without {cells} of '{column}' that {hold} no number ({where})"


def _without_times(
    path: Path, named: set[str], there: list[str], tell: Callable[[str], None]
) -> float:
    """Rows per second of a table that says none: one, for a distance sensor beside a ruler.

    Raises RecordingError where times are needed.
    """
    if not {"distance", "range"} <= named or MOVING & named:
        raise no_time(path, there)
    tell(
        f"{path.name}: has no times, and a distance sensor needs none: where a time is reported,"
        " one row is one second"
    )
    return 1.0


def _table(path: Path, mapping: Mapping, tell: Callable[[str], None]) -> ForeignTable:
    """The file's own columns: of a log, a Parquet file, or any text with separators."""
    if is_log(path):
        sources = [
            mapping.columns[name].from_
            for name in ("t", *mapping.columns)
            if name in mapping.columns
        ]
        topics = [topic_of(source) for source in sources if source is not None]
        table = read_log(path, next(filter(None, topics), None))
        timed = table if "t" in mapping.columns else {"t": table[LOG_TIME], **table}
        return ForeignTable(timed, [], set())
    if is_parquet(path):
        return ForeignTable(read_parquet_table(path), [], set())
    marks = _marks(path, mapping, tell)
    layout = *_headed(path, mapping, marks), *marks
    other = other_separator(path, mapping.separator)
    try:
        read = read_table(path, *layout, lambda words: tell(f"{path.name}: {words}"))
    except RecordingError as error:
        if other:
            raise RecordingError(f"{path}: {other}") from None
        typed = f"; how it can be read: deltactl inspect {path}"
        raise error.with_typed(typed) from None
    if other and len(read.columns) == 1:
        raise RecordingError(f"{path}: {other}")
    return read


def _headed(path: Path, mapping: Mapping, marks: tuple[str, str]) -> tuple[int, tuple[str, ...]]:
    """Lines before the table, and names of its columns where no line has them: as they are said;
    else as `inspect` finds them, where those are the names that are asked for.
    """
    said = mapping.skip_lines, mapping.heading
    asked = {source.from_ for source in mapping.columns.values()}
    try:
        form = guess_format(path, *marks)
    except RecordingError:
        return said
    there = {*form.names, *map(without_unit, form.names)}
    return said if any(said) or asked.isdisjoint(there) else (form.skip_lines, form.heading)


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

    Raises RecordingError where both are said and are not the same, and for a length that is to be
    read as an angle, or an angle as a length. A factor that was given, 1 too,
    is taken as it is.
    """
    heading = unit_said(column, name)
    if "scale" in source.model_fields_set:
        return source.unit
    if "unit" not in source.model_fields_set:
        if heading != "m":  # theta_m may be an angle of a motor
            _refuse_other_quantity(path, column, name, heading or "1")
        return heading or "1"
    _refuse_other_quantity(path, column, name, source.unit)
    if heading is not None and _contradict(heading, source.unit):
        plain = without_unit(column)
        raise RecordingError(
            f"{path}: {name} is given in {source.unit}, and the heading '{column}' says {heading};"
            f' type --set "{name}={plain}[{heading}]", or, where the heading is wrong,'
            f' --set "{name}={plain}[{source.unit}]*1"'
        )
    return source.unit


def _refuse_other_quantity(path: Path, column: str, name: str, unit: str) -> None:
    """Raise RecordingError where a column that is an angle has a unit of length, or the reverse."""
    wrong, is_a, other = {
        "rad": (LINEAR, "an angle", "position (and command) of an axis that slides"),
        "m": (ROTARY, "a length", "position (and command) of an axis that turns"),
    }.get(known_unit(name) or "", ((), "", ""))
    if unit in wrong:
        raise RecordingError(
            f"{path}: {name} is {is_a}, and column '{column}' is in {unit}; read it as {other},"
            f" or give the right unit"
        )


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
