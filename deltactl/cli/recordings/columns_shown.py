"""What `inspect` shows of a table: the columns that are used first, on one screen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.measure import Measurement
from rich.table import Table

from deltactl.cli.output import broken, console, facts, say
from deltactl.foundation.one_screen import LINES

if TYPE_CHECKING:
    from deltactl.diagnosis.observations.readings import FloatArray
    from deltactl.recording.foreign.found import Inspection
    from deltactl.recording.foreign.names import Guess

MOST_COLUMNS, MOST_USED, FEWEST_COLUMNS = 12, 8, 3
OF_AN_AXIS = 4
"""Columns that are always shown: time, command, reading and effort of an axis. Those of an arm's
joints are alike.
"""
NARROW = 100
"""In a window of fewer letters the reasons are below the table, not in a column of it."""
ENDLESS = 10_000
VALUES = 3
"""First values of a column that are shown where they fit."""
UNSAID = {"theta": "rad", "velocity": "rad/s or m/s"}
"""In what a column is read of which nothing says the unit."""
LONG, TOO_LONG = 1e4, 1e7
"""Between these, four figures would be written with a power of ten, and are read less easily."""


def print_columns(seen: Inspection, warnings: Sequence[str], closing: Sequence[str]) -> None:
    """Print what the file is and its columns, as many as one screen has room for beside the rest.

    warnings: printed below them, those about columns that are not read only where there is room.
    closing: lines that are printed below that.
    """
    kind = f"{seen.kind or 'unknown'} ({seen.kind_why})"
    head = facts(str(seen.path), [*seen.facts, ("machine", kind)])
    narrow, order = console.width < NARROW, _in_order(seen)
    fewest = min(len(seen.guesses), MOST_USED) or FEWEST_COLUMNS
    lines = len(console.render_lines(head)) + len(["", "heading", "more"])
    warnings = _looks(warnings, seen, LINES - lines - fewest - len(closing))
    taken = lines + len(warnings) + len(closing) + _folded(seen, order[:fewest], narrow)
    room = LINES - taken - fewest
    fewest = max(fewest + min(room, 0), min(fewest, OF_AN_AXIS))
    room = max(room, 0)
    apart = room >= sum(map(bool, (warnings, closing)))
    room -= sum(map(bool, (warnings, closing))) if apart else 0
    why = _why(seen, order[:MOST_COLUMNS], narrow)[:room]
    shown = order[: min(fewest + max(room - len(why), 0), max(MOST_COLUMNS, fewest))]
    most = LINES - lines - len(warnings) - len(closing) - len(why) + len(["heading", "more"])
    console.print(head)
    console.print()
    console.print(_as_high(seen, shown, narrow, most))
    for part in (why, warnings, closing):
        if apart and part and part is not why:
            console.print()
        for line in part:
            say(line)


def _folded(seen: Inspection, names: Sequence[str], narrow: bool) -> int:
    """Lines that some columns take beside one each, where names are too long for one line."""
    around = 1 + (len(names) < len(seen.table))  # the heading, and how many more there are
    return len(console.render_lines(_table(seen, names, narrow))) - len(names) - around


def _as_high(seen: Inspection, names: Sequence[str], narrow: bool, most: int) -> Table:
    """The table of some columns; long names take several lines of it, so that where it gets higher
    than so many lines the last columns are left out.
    """
    number = len(names)
    table = _table(seen, names, narrow)
    while number > OF_AN_AXIS and len(console.render_lines(table)) > most:
        number -= 1
        table = _table(seen, names[:number], narrow)
    return table


def _looks(warnings: Sequence[str], seen: Inspection, most: int) -> list[str]:
    """Lines of warnings; where not all have room without those about columns that are not read, and
    where these have none either without the unit of the times, which the table shows.
    """
    from deltactl.recording.foreign.names import of_role
    from deltactl.recording.foreign.notes import about_any

    times = of_role(seen.guesses, "t")
    for columns in (seen.table, seen.guesses, seen.guesses.keys() - {*times}):
        shown = [broken(f"look here: {one}") for one in about_any(warnings, columns)]
        if sum(map(len, shown)) <= most:
            break
    return [line for lines in shown for line in lines]


def _in_order(seen: Inspection) -> list[str]:
    """The names of the columns: those that are used, those that may be, and the rest."""
    from deltactl.recording.foreign.found import KEPT

    def rank(name: str) -> int:
        return 0 if name in seen.guesses else 2 - seen.unused(name).startswith(f"{KEPT};")

    return sorted(seen.table, key=rank)


def _why(seen: Inspection, names: Sequence[str], narrow: bool) -> list[str]:
    """Lines with empty cells and, in a narrow window, the reasons that are neither the column's
    name nor that it is merely kept.
    """
    from deltactl.recording.foreign.found import KEPT
    from deltactl.recording.foreign.names import BY_NAME

    number = {name: int(np.isnan(seen.table[name]).sum()) for name in names}
    few = [f"{n} of {name}" for name, n in number.items() if 0 < n < len(seen.table[name])]
    lines = broken(f"empty cells: {', '.join(few)}") if few else []
    for name in names if narrow else ():
        if name in seen.guesses and seen.guesses[name].why != BY_NAME:
            lines += broken(f"why {name}: {seen.guesses[name].why}")
    for name in names if narrow else ():
        if name not in seen.guesses and (why := seen.unused(name)) != KEPT:
            lines += broken(f"why not {name}: {why}")
    return lines


def _table(seen: Inspection, shown: Sequence[str], narrow: bool) -> Table:
    """With as many first values as leave each column on one line, at least one."""
    widths = (_preview(seen, shown, narrow, values) for values in range(VALUES, 1, -1))
    endless = console.options.update(width=ENDLESS)
    whole = (
        one for one in widths if Measurement.get(console, endless, one).maximum <= console.width
    )
    return next(whole, None) or _preview(seen, shown, narrow, 1)


def _preview(seen: Inspection, shown: Sequence[str], narrow: bool, first: int) -> Table:
    """One line per column: its name, what it is read as, why, and its first values."""
    table = Table(box=None, pad_edge=False, title_justify="left")
    values_of = "first values" if first > 1 else "first"
    headings = ["column", "taken for", "unit", values_of, "from", "to", "why"]
    for heading in headings[:-1] if narrow else headings:
        table.add_column(heading, overflow="fold")
    for name in shown:
        values, guess = seen.table[name], seen.guesses.get(name)
        known = values[np.isfinite(values)]
        ends = (known.min(), known.max()) if len(known) else ()
        cells = [
            name,
            guess.name if guess else "-",
            _unit(seen, guess) if guess else "",
            _values(values[:first], guess) if len(known) else "",
            *(list(map(_figure, ends)) or ["", ""]),
            guess.why if guess else seen.unused(name),
        ]
        table.add_row(*cells[: len(table.columns)])
    if len(seen.table) > len(shown):
        table.caption = f"and {len(seen.table) - len(shown)} more: see --json"
    return table


def _unit(seen: Inspection, guess: Guess) -> str:
    from deltactl.recording.foreign.units import LONE

    if seen.asked and guess.name in LONE and guess.unsaid:
        return "UNIT"
    if seen.asked and guess.name == "velocity" and guess.unsaid:
        return "UNIT/s"
    unit = f"{guess.unit or ''}{'?' * guess.unit_guessed}"
    if guess.factor is not None:
        return f"? {guess.unit or ''}".rstrip()
    if guess.scale != 1.0:
        return f"{guess.scale:.4g} {unit}".rstrip()
    if guess.unit is not None:
        return unit
    source = seen.mapping.columns.get(guess.name)
    taken = f"{source.unit}?" if source is not None and source.unit != "1" else None
    return taken or UNSAID.get(guess.role) or ("rad?" if guess.role in LONE else "as it is")


def _values(first: FloatArray, guess: Guess | None) -> str:
    """Values (n,) of the first rows; of times the first, and what comes after it."""
    if guess is None or guess.role != "t" or abs(float(first[0])) < LONG:
        return " ".join(map(_figure, first))
    later = (f"+{_figure(value - first[0])}" for value in first[1:])
    return " ".join([f"{first[0]:.10g}", *later])


def _figure(value: float) -> str:
    """Four figures, and up to seven before the point rather than a power of ten."""
    plain = value + 0.0  # no -0
    return f"{plain:.0f}" if LONG <= abs(plain) < TOO_LONG else f"{plain:.4g}"
