"""`deltactl diagnose --inspect`: what a table seems to be, and the command that reads it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.table import Table

from command_line.missing import refuse_missing
from command_line.output import console, facts, print_json, say
from command_line.recordings.diagnose import mapping_of
from command_line.wrapped import print_wrapped
from foundation.extras import needs

if TYPE_CHECKING:
    from diagnosis.columns.inspection import Inspection
    from diagnosis.columns.names import Guess
    from diagnosis.observations.readings import FloatArray

ROBOT = "my-robot.yaml"
SHOWN_COLUMNS = 12
NARROW = 100
"""In a window of fewer letters the reasons stand below the table, not in a column of it."""
BY_NAME = "by its name"
FORCED = " --recorded effort --inertia INERTIA --effort-gain GAIN"
FORCED_SAYS = (
    "                       INERTIA: what moves, in kg m2 (rotary) or kg (linear), as well as it is"
    " known;\n                       GAIN: N m (or N) for one unit of the effort; where a weight"
    " pulls at it,\n                       also --hanging-nm (rotary) or --slope-n (linear)"
)


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
    with needs("diagnosis", "diagnose --inspect"):
        from diagnosis.columns.inspection import inspect
    refuse_missing(recordings)
    known = mapping_of(columns)
    seen = [inspect(path, known) for path in recordings]
    if as_json:
        print_json([_as_json(one) for one in seen])
    else:
        for one in seen:
            _show(one, robot, save)
    if save is not None:
        save.write_text(seen[0].mapping_text(), encoding="utf-8")
        if not as_json:
            say(f"mapping: {save}")


def _as_json(one: Inspection) -> dict[str, Any]:
    return {
        "file": one.path,
        "facts": dict(one.facts),
        "kind": one.kind,
        "motion": one.motion,
        "columns": {
            name: asdict(guess) | {"name": guess.name} for name, guess in one.guesses.items()
        },
        "options": one.options,
        "warnings": one.warnings,
    }


def _show(one: Inspection, robot: str | None, save: Path | None) -> None:
    kind = f"{one.kind or 'unknown'} ({one.kind_why})"
    console.print(facts(str(one.path), [*one.facts, ("machine", kind)]))
    console.print()
    narrow = console.width < NARROW
    console.print(_preview(one, narrow))
    if narrow:
        _say_why(one)
    print_wrapped(escape(f"look here: {warning}") for warning in one.warnings)
    if one.kind is None:
        return
    console.print()
    if robot is None:
        motion = f" --motion {one.motion or 'rotary'}" if one.kind == "servo_axis" else ""
        zero = " --zero arbitrary" if one.zero == "arbitrary" else ""
        motion += FORCED if one.needs_inertia else ""
        say(f"describe the machine:  deltactl init {_new(one)} --kind {one.kind}{motion}{zero}")
        if one.needs_inertia:
            say(FORCED_SAYS)
    read = ["--columns", str(save)] if save is not None else one.options
    say(f"diagnose it:           {one.command(robot or _new(one), read)}")


def _new(one: Inspection) -> str:
    """A robot file name that is still free: a second machine gets its own file."""
    return f"{one.path.stem}-robot.yaml" if Path(ROBOT).exists() else ROBOT


def _values(values: FloatArray, guess: Guess | None) -> str:
    """The first three; of times the first, and what comes after it."""
    first = values[:3]
    if guess is None or guess.role != "t" or abs(float(first[0])) < 1e4:
        return " ".join(f"{value:.4g}" for value in first)
    later = (f"+{value - first[0]:.4g}" for value in first[1:])
    return " ".join([f"{first[0]:.10g}", *later])


def _unit(guess: Guess) -> str:
    if guess.scale == 1.0:
        return guess.unit or "as it is"
    return f"{guess.scale:.4g} {guess.unit or ''}".rstrip()


def _say_why(one: Inspection) -> None:
    """The reasons that are not simply the column's name."""
    shown = list(one.table)[:SHOWN_COLUMNS]
    for name in shown:
        if name in one.guesses and one.guesses[name].why != BY_NAME:
            say(f"why {name}: {one.guesses[name].why}")
    for name in shown:
        if name not in one.guesses:
            say(f"why not {name}: {one.unused(name)}")


def _preview(one: Inspection, narrow: bool) -> Table:
    """One line per column: its name, what it is read as, why, and its first values."""
    table = Table(box=None, pad_edge=False, title_justify="left")
    headings = ["column", "taken for", "unit", "first values", "from", "to", "why"]
    for heading in headings[:-1] if narrow else headings:
        table.add_column(heading, overflow="fold")
    for name, values in list(one.table.items())[:SHOWN_COLUMNS]:
        guess = one.guesses.get(name)
        low, high = float(values.min()), float(values.max())
        cells = [
            name,
            guess.name if guess else "-",
            _unit(guess) if guess else "",
            _values(values, guess),
            f"{low:.4g}",
            f"{high:.4g}",
            guess.why if guess else one.unused(name),
        ]
        table.add_row(*cells[: len(table.columns)])
    if len(one.table) > SHOWN_COLUMNS:
        table.caption = f"and {len(one.table) - SHOWN_COLUMNS} more"
    return table
