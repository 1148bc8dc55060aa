"""What a table of somebody else seems to be: its columns, units, rate, and kind of machine.

In: a file. Out: an `Inspection`, with the mapping that reads it. Every guess says why, and what
remains unknown is said too.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping as AnyMapping
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.printable import count
from deltactl.recording.foreign.axis_columns import EARLIER
from deltactl.recording.foreign.doubts import far_from_readings
from deltactl.recording.foreign.found import Inspection, init_words, robot_named_after
from deltactl.recording.foreign.guess import guess_columns
from deltactl.recording.foreign.guessed_units import (
    meant_otherwise,
    unit_noted,
    with_units,
)
from deltactl.recording.foreign.joints import (
    departing_motor,
    of_data_set,
    of_other_joints,
    one_joint,
)
from deltactl.recording.foreign.kinds import (
    HERE,
    from_outside,
    kind_of,
    may_be_asked,
    second_reading,
    zero_of,
)
from deltactl.recording.foreign.mapping import Mapping, Source
from deltactl.recording.foreign.motion_units import (
    NO_UNIT,
    Asked,
    ask_unit,
    in_unit,
    motion_beside,
    turns_by_name,
)
from deltactl.recording.foreign.names import (
    AS_SAID,
    BY_NAME,
    Guess,
    Taken,
    by_name,
    of_contract,
    of_role,
    read_name,
    without_unit,
)
from deltactl.recording.foreign.notes import Hint, Note
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.owners_factors import with_factors
from deltactl.recording.foreign.reading import against_heading, named_column, unit_of
from deltactl.recording.foreign.shapes import Table, rising
from deltactl.recording.foreign.timing import (
    Stumbling,
    row_number,
    rows_and_times,
    stumbling,
)
from deltactl.recording.foreign.units import IN_SI, LONE
from deltactl.recording.format.messages import MOTORS
from deltactl.recording.reading.run import FloatArray
from deltactl.recording.tables.binary_tables import JOINTS, files_of, is_data_set, names_of
from deltactl.recording.tables.flat import OF_A_CHAIN, TARGET, UNITS
from deltactl.recording.tables.flat_files import is_own_run, read_flat
from deltactl.recording.tables.foreign_log import is_log, read_log, topic_of
from deltactl.recording.tables.foreign_table import is_parquet, read_parquet_table, read_table
from deltactl.recording.tables.table_format import TableFormat, guess_format, marks_said, rate_said


def inspect(path: Path, said: Mapping | None = None, motion: str | None = None) -> Inspection:
    """Look at a table; `said`: columns that are known already, the others are guessed.

    motion: linear or rotary, of a single axis whose robot file says it.
    Raises RecordingError when it holds no columns of numbers, or not those that are said.
    """
    known = {} if said is None else said.columns
    if is_own_run(path) and not known:
        return _of_own_run(path)
    if is_log(path) or is_parquet(path):
        return _of_columns(path, known, said or Mapping(), motion)
    form = guess_format(path, *((said.separator, said.decimal) if said else ()))
    remarks: list[str] = []
    skip, heading = form.skip_lines, form.heading
    try:
        table = read_table(path, skip, heading, form.separator, form.decimal, remarks.append)
    except RecordingError as error:
        raise RecordingError(f"{error}: it is no table of numbers, or has rows of text") from None
    units = dict(zip(form.names, form.units, strict=True)) | dict.fromkeys(table.dated, "s")
    base = _said_of_the_table(said).model_copy(update={"skip_lines": skip, "heading": heading})
    facts = _facts(form) + [("remarks", words) for words in remarks]
    text = form.named, form.before, table.lines, said.unit if said else None
    read = _Read(path, table.columns, base, facts, units, *text)
    return _inspected(read, known, motion)


def _of_own_run(path: Path) -> Inspection:
    """A run that the program recorded, as the diagnosis reads it."""
    flat = read_flat(path)
    table = {"t": flat.t_s, **flat.columns, **flat.extra}
    facts = [("written", "a recording of deltactl")]
    return replace(_inspected(_Read(path, table, Mapping(), facts), {}), own_run=True)


def _said_of_the_table(said: Mapping | None) -> Mapping:
    """What somebody says of the whole table. What is found by looking needs no saying."""
    known = {"separator", "decimal", "rate_hz", "leave_out"}
    kept = {} if said is None else said.model_dump(include=known)
    return Mapping.model_validate(kept)


def _of_columns(
    path: Path, known: AnyMapping[str, Source], said: Mapping, motion: str | None
) -> Inspection:
    """A log or a Parquet file: its columns have names already."""
    table = read_log(path) if is_log(path) else read_parquet_table(path)
    topics = sorted({topic for name in table if (topic := topic_of(name))})
    facts = [("topics", ", ".join(topics))] if topics else [("written", "Parquet")]
    if is_data_set(path):
        facts = [("written", f"LeRobot data set, {count(len(files_of(path)), 'file')}")]
    if joints := names_of(path).get(JOINTS[0]):
        facts.append(("joints", ", ".join(joints)))
    units, of_units = of_data_set(table)
    base = _said_of_the_table(said)
    found = _inspected(_Read(path, table, base, facts, units, unit=said.unit), known, motion)
    return replace(found, warnings=[*of_units, *found.warnings])


@dataclass(frozen=True, slots=True, eq=False)
class _Read:
    """Columns that are read already; `base` says how the file is written."""

    path: Path
    table: dict[str, FloatArray]
    base: Mapping
    facts: list[tuple[str, str]]
    units: AnyMapping[str, str] = field(default_factory=dict)
    named: bool = True
    before: Sequence[str] = ()
    """The lines above the table."""
    lines: Sequence[int] = ()
    """The lines of its rows, where it has such."""
    unit: str | None = None
    """What somebody says of the motion of an axis."""


def _inspected(read: _Read, said: AnyMapping[str, Source], moves: str | None = None) -> Inspection:
    """What columns that are not said seem to be. moves: linear or rotary, where that is known."""
    known = _with_numbers(read)
    if not said and (whole := _measured_chain(read, known)) is not None:
        return whole
    guesses, known, warnings = _guessed(read, known, said, moves)
    guesses, of_load = from_outside(guesses, known)
    left = [name for name, one in known.items() if name not in guesses and not rising(one)]
    constant = (name for name, one in said.items() if one.value is not None)
    kind, motion, why = kind_of(guesses, left, constant)
    if kind == "range_sensor" and (far := _far_from_readings(guesses, known, said)):
        raise RecordingError(f"{read.path}: {far}")
    taken, asked = dict[str, str](), None
    if kind == "servo_axis":
        taken, asked, motion = _of_an_axis(guesses, known, motion, moves)
        warnings += [*_asking(asked), *of_load]
    warnings += _of_the_kind(kind, guesses, known)
    timeless = read.base.rate_hz is not None and "t" not in said
    read, guesses, late, left_out = _timed(read, guesses, known, kind, timeless)
    columns, zero = _as_columns(guesses, said, taken), zero_of(guesses, known)
    mapping = read.base.model_copy(update={"columns": columns})
    found = (read.path, read.facts, read.table, guesses, kind, motion, why, zero, mapping)
    return Inspection(*found, [*warnings, *late], *left_out, named=read.named, asked=asked)


def _with_numbers(read: _Read) -> dict[str, FloatArray]:
    """The columns to look at. Raises RecordingError for a table without rows."""
    if not read.table or not len(next(iter(read.table.values()))):
        raise RecordingError(f"{read.path}: has no rows")
    return {
        name: one
        for name, one in read.table.items()
        if name not in read.base.leave_out and np.isfinite(one).any()
    }


def _asking(asked: Asked | None) -> list[str]:
    """That somebody has to say the unit of an axis."""
    if asked is None:
        return []
    put = "so put it for UNIT below"
    return [Hint.of(NO_UNIT, "unit", asked.columns, asked.units, put)]


def _of_the_kind(kind: str | None, guesses: Taken, table: Table) -> list[str]:
    """What else a table of such a machine may be."""
    if kind == "servo_axis":
        return [*may_be_asked(guesses, table), *second_reading(guesses, table)]
    motor = departing_motor(table, guesses) if kind == "delta" else None
    return [] if motor is None else [Note(_of_three_motors(motor), [motor])]


def _far_from_readings(guesses: Taken, table: Table, said: AnyMapping[str, Source]) -> str:
    """Why one distance that somebody says for all rows is not what was read; empty where it is."""
    if "distance" not in said or (distance_m := said["distance"].value) is None:
        return ""
    guess = by_name(guesses)["range"]
    read_m = table[guess.source] * guess.scale * IN_SI[guess.unit or "1"]
    return far_from_readings(distance_m, read_m, guess.source)


def _of_an_axis(
    guesses: Taken, known: Table, motion: str | None, moves: str | None
) -> tuple[dict[str, str], Asked | None, str | None]:
    """Units that are taken until they are said, what is to be asked, and the motion, of an axis.

    motion: that of its units, which may be guesses. moves: that which is known.
    """
    turns = turns_by_name(guesses.values())
    sure = any(one.unit and not one.unit_guessed for one in guesses.values() if one.name in LONE)
    moves = moves or (motion if sure else "rotary" if turns else motion_beside(guesses))
    taken, asked = ask_unit(guesses, known, moves)
    return taken, asked, moves if asked else motion or moves


def _guessed(
    read: _Read, known: dict[str, FloatArray], said: AnyMapping[str, Source], moves: str | None
) -> tuple[dict[str, Guess], dict[str, FloatArray], list[str]]:
    """What columns are taken for, the columns of the joint that is looked at, and warnings."""
    path, table = read.path, read.table
    chosen = [named_column(path, table, name, one) for name, one in said.items() if one.from_]
    lone = not said.keys().isdisjoint(LONE)
    known, others = one_joint(known, chosen, lone) if read.named else (known, [])
    guesses = {
        name: guess
        for name, guess in guess_columns(known, read.units, read.named).items()
        if guess.name in UNITS and guess.name not in read.base.leave_out
    }
    guesses = in_unit(_as_said(path, table, guesses, said), read.unit)
    guesses, noted = unit_noted(guesses, read.before)
    guesses, owed = with_factors(guesses, known)
    guesses, warnings = with_units(guesses, known, moves)
    warnings += [*noted, *owed]
    warnings += meant_otherwise(guesses, read.units)
    warnings += _which_came_first(guesses)
    others += of_other_joints(known, guesses)
    if others:
        says = _of_more_joints(path, others, bool(chosen))
        warnings.append(Note(says, [*others, *of_role(guesses, *LONE)]))
    return guesses, known, warnings


def _timed(
    read: _Read,
    guesses: dict[str, Guess],
    known: dict[str, FloatArray],
    kind: str | None,
    timeless: bool,
) -> tuple[_Read, dict[str, Guess], list[str], tuple[str | None, str | None]]:
    """The table with what is known of its times, guesses, and warnings.

    Last: a column that counts the rows, and one whose times do not increase in every row.
    timeless: somebody says the rate instead of a column of times.
    """
    base = read.base
    counter = row_number(guesses, known) if kind == "range_sensor" else None
    if timeless or counter:
        guesses = _without_times(guesses)
    unsaid = base.rate_hz is None and not of_role(guesses, "t")
    above = rate_said(read.before) if unsaid else None
    facts, late = rows_and_times(guesses, known, kind, base.rate_hz if timeless else None, above)
    stumbles = None if timeless else stumbling(guesses, known, read.lines, kind)
    if stumbles:
        late = stumbles.instead_of(late)
        guesses = _without_times(guesses) if stumbles.rate_hz else guesses
    if (unsaid or stumbles) and (rate_hz := _rate_instead(kind, above, stumbles)):
        base = base.model_copy(update={"rate_hz": rate_hz})
    left_out = (counter, stumbles.name if stumbles else None)
    return replace(read, base=base, facts=[*read.facts, *facts]), guesses, late, left_out


def _rate_instead(
    kind: str | None, above: tuple[float, str] | None, stumbles: Stumbling | None
) -> float | None:
    """Rows a second of a table without times that can be read; None where none is needed.

    above: what a line above the table says of them, and that line.
    """
    if kind is not None and above is not None:
        return above[0]
    if stumbles is not None:
        return stumbles.rate_hz
    return None if kind in (None, "range_sensor") else GUESSES.rate_hz


def _as_columns(
    guesses: Taken, said: AnyMapping[str, Source], asked: AnyMapping[str, str]
) -> dict[str, Source]:
    """The columns of a mapping: what differs from the contract, and what was said of it."""
    columns = {
        guess.name: Source.model_validate(
            {"from": name, "unit": guess.unit or asked.get(guess.name, "1")}
            | ({"scale": guess.scale} if guess.scale != 1.0 or against_heading(guess) else {})
        )
        for name, guess in sorted(guesses.items(), key=lambda one: list(UNITS).index(one[1].name))
    }
    columns = {
        name: source
        for name, source in columns.items()
        if source.from_ != name
        or IN_SI[source.unit] != 1.0
        or source.scale != 1.0
        or name in asked
        or (name in said and "unit" in said[name].model_fields_set)
    }
    return columns | {
        name: one
        for name, one in said.items()
        if one.from_ is None or "scale" in one.model_fields_set or one.offset
    }


def _measured_chain(read: _Read, known: Table) -> Inspection | None:
    """More joints than a delta has beside places of a target; None where there are not both."""
    own = [name for name in known if OF_A_CHAIN.fullmatch(name)]
    joints = {name.partition("_")[2] for name in own if name.startswith(("theta_", "command_"))}
    if len(joints) <= MOTORS or not any(map(TARGET.fullmatch, own)):
        return None
    why = f"{count(len(joints), 'joint')}, and where a target on it was measured"
    rows = str(len(next(iter(known.values()))))
    at_rest = "" if "t" in known else ", without times, which poses at rest do not need"
    guesses = {name: Guess(name, *name.partition("_")[::2], None, BY_NAME) for name in own}
    facts = [*read.facts, ("rows", f"{rows}{at_rest}")]
    return Inspection(read.path, facts, read.table, guesses, "chain", None, why, None, read.base)


def _of_three_motors(reading: str) -> str:
    """Words for three motors that may be joints of another machine; reading: of one of them."""
    one = shlex.join(["--set", f"position={without_unit(reading)}"])
    return (
        "three motors are taken for those of a delta; the joints of another machine are diagnosed"
        f" one by one: {HERE} {one}"
    )


SHOWN_OTHERS = 3


def _of_more_joints(table: Path, others: Sequence[str], chosen: bool) -> str:
    """Words for columns of joints that are not shown; chosen: somebody named the joint that is."""
    named = ", ".join(others[:SHOWN_OTHERS]) + ", ..." * (len(others) > SHOWN_OTHERS)
    says = f"there are more joints than one: {named}"
    if chosen:
        return f"{says}; name those of another with --set"
    return (
        f"{says}; shown is the first, or one that departs clearly more from its command; name those"
        f" of another with --set{_of_an_arm(table) if _are_of_an_arm(others) else ''}"
    )


def _of_an_arm(table: Path) -> str:
    init = init_words("chain", f"{robot_named_after(table)}.yaml")
    return f"; all joints of an arm together, with its URDF: {shlex.join(['deltactl', *init])}"


def _are_of_an_arm(others: Sequence[str]) -> bool:
    """Whether readings of more joints than a delta has are numbered."""
    read = [one for one in others if read_name(one).role == "position"]
    return len([one for one in read if any(map(str.isdigit, one))]) >= MOTORS


def _without_times(guesses: Taken) -> dict[str, Guess]:
    return {name: one for name, one in guesses.items() if one.role != "t"}


def _which_came_first(guesses: Taken) -> list[str]:
    """A word of two columns of which only the numbers say which was asked for."""
    asked = [guess.source for guess in guesses.values() if guess.why.endswith(EARLIER)]
    if not asked:
        return []
    are = "the command, as it is" if len(asked) == 1 else "commands, as they are"
    says = f"taken for {are} {EARLIER}; if it is the reading, exchange the two in the command below"
    return [Note.on(asked, says)]


def _as_said(
    path: Path, table: Table, guesses: Taken, said: AnyMapping[str, Source]
) -> dict[str, Guess]:
    """Guesses, less those that somebody knows better. Raises RecordingError (no such column)."""
    sure: dict[str, Guess] = {}
    for name, source in said.items():
        if source.from_ is None:
            continue
        column = named_column(path, table, name, source)
        role, index = of_contract(name)
        said_unit = unit_of(path, column, name, source)
        unit = None if said_unit == "1" else said_unit
        sure[column] = Guess(column, role, index, unit, AS_SAID, source.scale)
    names = {guess.name for guess in sure.values()}
    left = {column: one for column, one in guesses.items() if one.name not in names}
    return left | sure


def _facts(form: TableFormat) -> list[tuple[str, str]]:
    heading = "with a heading" if form.named else "no heading: columns are numbered"
    facts = [("written", f"{form.mark}, {marks_said(form.separator, form.decimal)}, {heading}")]
    if form.before:
        facts.append(
            ("before that", f"{count(len(form.before), 'line')}, as '{form.before[0][:50]}'")
        )
    return facts
