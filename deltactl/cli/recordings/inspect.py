"""`deltactl inspect`: what a table seems to be, and the command that reads it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.markup import escape
from rich.table import Table

from deltactl.cli.file_arguments import refuse_missing
from deltactl.cli.output import console, facts, print_json, print_wrapped, say, warn
from deltactl.cli.recordings.tables import mapping_of
from deltactl.foundation.errors import RecordingError
from deltactl.foundation.extras import needs
from deltactl.foundation.plain_file import write_whole

if TYPE_CHECKING:
    from deltactl.diagnosis.observations.readings import FloatArray
    from deltactl.recording.foreign.found import Inspection
    from deltactl.recording.foreign.names import Guess

ROBOT = "my-robot.yaml"
SHOWN_COLUMNS = 12
NARROW = 100
"""In a window of fewer letters the reasons are below the table, not in a column of it."""
UNSAID = {
    "command": "rad?",
    "position": "rad?",
    "theta": "rad",
    "velocity": "rad/s or m/s",
}
"""In what a column is read of which nothing says the unit."""
OF_THE_RUN = "ROBOT is the robot file that it was made with"
LONG, TOO_LONG = 1e4, 1e7
"""Between these, four figures would be written with a power of ten, and are read less easily."""
BY_NAME = "by its name"
FORCED = ["--recorded", "effort", "--inertia", "INERTIA", "--effort-gain", "GAIN"]
FORCED_SAYS = (
    "  INERTIA: what moves, in kg m2 (rotary) or kg (linear), as well as it is known",
    "  GAIN: N m (or N) for one unit of the effort; where a weight pulls at it, also {weight}",
)
MEASURED_SAYS = (
    "  inertia {inertia:.3g} for an effort_gain of 1, as the effort goes with the acceleration:"
    " sizes are then in the unit of the effort; where one of the two is known, add --inertia or"
    " --effort-gain, and the other follows; where a weight pulls at it, also {{weight}}"
)
STEPPED = ["--microsteps-per-rev", "STEPS", "--gear-ratio", "GEAR"]
STEPPED_SAYS = (
    "  STEPS: step pulses for one turn of the motor, as set at the drive: 1600, or 200x8",
    "  GEAR: turns of the motor for one turn of the axis: 5 for a gear of 5:1, 1 without a gear",
)
WEIGHT = {"rotary": "--hanging-nm", "linear": "--slope-n"}
"""The option that says what a weight does, by what the axis does."""


def inspect_recordings(
    recordings: list[Path],
    robot: str | None,
    save: Path | None,
    as_json: bool,
    columns: list[str],
) -> None:
    """Print what each table seems to be. Raises RecordingError or ConfigError.

    columns: what is known already, as --columns and --set say it.
    """
    with needs("diagnosis", "inspect"):
        from deltactl.recording.foreign.inspection import inspect
    refuse_missing(recordings)
    known = mapping_of(columns)
    seen = _readable(recordings, lambda path: _measured(inspect(path, known)))
    if as_json:
        print_json([table.to_json() for table in seen])
    else:
        for table in seen:
            _show(table, robot, save)
    if save is not None:
        write_whole(save, seen[0].mapping_text())
        if not as_json:
            say(f"mapping: {save}")


def _measured(seen: Inspection) -> Inspection:
    """With a word of a table that is too short for a diagnosis."""
    from deltactl.diagnosis.observations.options import OBSERVATIONS
    from deltactl.diagnosis.plants.lone.options import COMMANDED_AXIS, FORCED_AXIS, RANGE_SENSOR

    fewest = {
        None: 0,
        "servo_axis": COMMANDED_AXIS.fewest_followed_rows,
        "range_sensor": RANGE_SENSOR.fewest_ranged_rows,
    }.get(seen.kind, OBSERVATIONS.fewest_samples)
    fewest = FORCED_AXIS.fewest_forced_rows if seen.needs_inertia else fewest
    rows = len(next(iter(seen.table.values())))
    if rows >= fewest:
        return seen
    short = f"{rows} rows are too few: a diagnosis needs {fewest} at least; record a longer run"
    return replace(seen, warnings=[*seen.warnings, short])


def _readable(paths: list[Path], inspect: Callable[[Path], Inspection]) -> list[Inspection]:
    """What is seen in those that can be read; one that cannot is named, and the others shown."""
    seen, damaged = [], []
    for path in paths:
        try:
            seen.append(inspect(path))
        except RecordingError as error:
            damaged.append(error)
    if not seen:
        raise damaged[0]
    for why in damaged:
        warn(f"{why}; the others follow")
    return seen


def _show(seen: Inspection, robot: str | None, save: Path | None) -> None:
    from deltactl.recording.foreign.found import init_words

    kind = f"{seen.kind or 'unknown'} ({seen.kind_why})"
    console.print(facts(str(seen.path), [*seen.facts, ("machine", kind)]))
    console.print()
    narrow = console.width < NARROW
    console.print(_preview(seen, narrow))
    if narrow:
        _say_why(seen)
    if empty := _empty(seen):
        _say_broken(f"empty cells: {empty}")
    if seen.warnings:
        console.print()
    for warning in seen.warnings:
        _say_broken(f"look here: {warning}")
    if seen.kind is None:
        return
    console.print()
    if seen.own_run:
        _say_broken(f"this is a recording of deltactl and is read as it is; {OF_THE_RUN}")
        robot = robot or "ROBOT"
    if robot is None:
        motion = ["--motion", seen.motion or "rotary"] if seen.kind == "servo_axis" else []
        zero = ["--zero", "arbitrary"] if seen.zero == "arbitrary" else []
        weight = WEIGHT[seen.motion or "rotary"]
        forced, says = _forced(seen) if seen.needs_inertia else ([], ())
        if seen.kind == "stepper_axis":
            forced, says = STEPPED, STEPPED_SAYS
        init = ["deltactl", *init_words(seen.kind, _new(seen)), *motion, *forced, *zero]
        _say_command("describe the machine:  ", init)
        for line in says:
            _say_broken(line.format(weight=weight))
    read = ["--columns", str(save)] if save is not None else seen.options
    if robot is None and save is None and _has_unused_effort(seen):
        also = "  to use the effort too, add to that --inertia and --effort-gain"
        if (
            effort := next((word for word in read if word.startswith("effort=")), None)
        ) is not None:
            at = read.index(effort)
            read = [*read[: at - 1], *read[at + 1 :]]
            also += f", and to the command --set {shlex.quote(effort)}"
        _say_broken(also)
    _say_command("diagnose it:           ", seen.command(robot or _new(seen), read))


def _has_unused_effort(seen: Inspection) -> bool:
    """Whether an effort is beside a command, which needs a robot file with an inertia."""
    there = {guess.name for guess in seen.guesses.values()}
    return seen.kind == "servo_axis" and not seen.needs_inertia and "effort" in there


def _forced(seen: Inspection) -> tuple[list[str], Sequence[str]]:
    """What describes an axis of which an effort was recorded, and what is said of it.

    Where the effort goes with the acceleration, the recording itself says what moves.
    """
    from deltactl.firmware_py.describing.robot_text import inertia_of
    from deltactl.recording.foreign.reading import read_mapped

    try:
        one = inertia_of(read_mapped(seen.path, seen.mapping))
    except RecordingError:
        one = None
    if one is None:
        return FORCED, FORCED_SAYS
    return ["--measure", str(seen.path), *seen.options], (MEASURED_SAYS.format(inertia=one),)


def _say_broken(text: str) -> None:
    """A sentence: in a window broken between words, elsewhere one line."""
    if console.is_terminal:
        print_wrapped([escape(text)])
    else:
        say(text)


def _say_command(label: str, words: list[str]) -> None:
    """A command to be copied; in a window too narrow for it, over lines that the shell joins."""
    whole = f"{label}{shlex.join(words)}"
    if not console.is_terminal or len(whole) <= console.width:
        say(whole)
        return
    say(label.rstrip())
    line = ""
    for part in _options(words):
        if line and len(line) + len(part) + 3 > console.width:
            say(f"{line} \\")
            line = "   "
        line = f"{line} {part}" if line else part
    say(line)


def _options(words: list[str]) -> Iterator[str]:
    """The words of a command, each option with its value."""
    part: list[str] = []
    for word in words:
        if word.startswith("--") and part:
            yield shlex.join(part)
            part = []
        part.append(word)
    yield shlex.join(part)


def _new(seen: Inspection) -> str:
    """A robot file name that is still free: a second machine gets its own file."""
    return f"{seen.path.stem}-robot.yaml" if Path(ROBOT).exists() else ROBOT


def _figure(value: float) -> str:
    """Four figures, and up to seven before the point rather than a power of ten."""
    plain = value + 0.0  # no -0
    return f"{plain:.0f}" if LONG <= abs(plain) < TOO_LONG else f"{plain:.4g}"


def _values(values: FloatArray, guess: Guess | None) -> str:
    """The first three; of times the first, and what comes after it."""
    first = values[:3]
    if guess is None or guess.role != "t" or abs(float(first[0])) < 1e4:
        return " ".join(map(_figure, first))
    later = (f"+{_figure(value - first[0])}" for value in first[1:])
    return " ".join([f"{first[0]:.10g}", *later])


def _unit(guess: Guess) -> str:
    if guess.scale == 1.0:
        return guess.unit or UNSAID.get(guess.role, "as it is")
    return f"{guess.scale:.4g} {guess.unit or ''}".rstrip()


def _say_why(seen: Inspection) -> None:
    """The reasons that are neither the column's name nor that it is merely kept."""
    from deltactl.recording.foreign.found import KEPT

    shown = list(seen.table)[:SHOWN_COLUMNS]
    for name in shown:
        if name in seen.guesses and seen.guesses[name].why != BY_NAME:
            _say_broken(f"why {name}: {seen.guesses[name].why}")
    for name in shown:
        if name not in seen.guesses and (why := seen.unused(name)) != KEPT:
            _say_broken(f"why not {name}: {why}")


def _empty(seen: Inspection) -> str:
    """How many cells of which columns hold no number, of those that are shown."""
    shown = list(seen.table.items())[:SHOWN_COLUMNS]
    empty = {name: int(np.isnan(values).sum()) for name, values in shown}
    few = {name: number for name, number in empty.items() if number < len(seen.table[name])}
    return ", ".join(f"{number} of {name}" for name, number in few.items() if number)


def _preview(seen: Inspection, narrow: bool) -> Table:
    """One line per column: its name, what it is read as, why, and its first values."""
    table = Table(box=None, pad_edge=False, title_justify="left")
    headings = ["column", "taken for", "unit", "first values", "from", "to", "why"]
    for heading in headings[:-1] if narrow else headings:
        table.add_column(heading, overflow="fold")
    for name, values in list(seen.table.items())[:SHOWN_COLUMNS]:
        guess = seen.guesses.get(name)
        known = values[np.isfinite(values)]
        ends = (known.min(), known.max()) if len(known) else ()
        cells = [
            name,
            guess.name if guess else "-",
            _unit(guess) if guess else "",
            _values(values, guess) if len(known) else "",
            *(list(map(_figure, ends)) or ["", ""]),
            guess.why if guess else seen.unused(name),
        ]
        table.add_row(*cells[: len(table.columns)])
    if len(seen.table) > SHOWN_COLUMNS:
        table.caption = f"and {len(seen.table) - SHOWN_COLUMNS} more"
    return table
