"""`deltactl diagnose --inspect`: what a table seems to be, and the command that reads it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.table import Table

from command_line.output import console, facts, print_json, say, warn
from foundation.errors import ConfigError
from foundation.extras import needs

if TYPE_CHECKING:
    from diagnosis.observations.inspection import Inspection

ROBOT = "my-robot.yaml"
SHOWN_COLUMNS = 12


def inspect_recordings(
    recordings: list[Path], robot: str | None, save: Path | None, as_json: bool
) -> None:
    """Print what each table seems to be. Raises RecordingError or ConfigError."""
    with needs("diagnosis", "diagnose --inspect"):
        from diagnosis.observations.inspection import inspect
    if save is not None and save.exists():
        raise ConfigError(f"--save-columns {save}: exists already; name another file")
    seen = [inspect(path) for path in recordings]
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
    console.print(_preview(one))
    for warning in one.warnings:
        warn(f"look here: {warning}")
    if one.kind is None:
        return
    console.print()
    if robot is None:
        motion = f" --motion {one.motion or 'rotary'}" if one.kind == "servo_axis" else ""
        zero = " --zero arbitrary" if one.zero == "arbitrary" else ""
        say(f"describe the machine:  deltactl init {ROBOT} --kind {one.kind}{motion}{zero}")
    read = ["--columns", str(save)] if save is not None else one.options
    say(f"diagnose it:           {one.command(robot or ROBOT, read)}")


def _preview(one: Inspection) -> Table:
    """One line a column: what it is called, what it is taken for, why, and its first values."""
    table = Table(box=None, pad_edge=False, title_justify="left")
    for heading in ("column", "taken for", "unit", "first values", "from", "to", "why"):
        table.add_column(heading, overflow="fold")
    for name, values in list(one.table.items())[:SHOWN_COLUMNS]:
        guess = one.guesses.get(name)
        low, high = float(values.min()), float(values.max())
        table.add_row(
            name,
            guess.name if guess else "-",
            (guess.unit or "as it is") if guess else "",
            " ".join(f"{value:.4g}" for value in values[:3]),
            f"{low:.4g}",
            f"{high:.4g}",
            guess.why if guess else "kept, not used",
        )
    if len(one.table) > SHOWN_COLUMNS:
        table.caption = f"and {len(one.table) - SHOWN_COLUMNS} more"
    return table
