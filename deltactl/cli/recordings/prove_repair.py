"""`deltactl prove --repair`: what correcting a robot gains, case by case."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn
from rich.table import Table

from deltactl.cli.output import console, errors, facts, millimetres, say
from deltactl.foundation.extras import needs
from deltactl.foundation.plain_file import write_whole

if TYPE_CHECKING:
    from deltactl.repair.campaign import Row


def prove_repair(
    cases: int,
    seed: int,
    out: Path,
    networks: bool,
    workers: int,
    scheduler: str | None,
    minutes: float,
) -> None:
    """Run the cases and print the table."""
    with needs("proof", "prove"):
        from deltactl.repair.campaign import prove_repair as run
        from deltactl.repair.campaign import summary
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True) as bars:
        bar = bars.add_task("", total=cases)

        def show(done: int, total: int) -> None:
            bars.update(bar, completed=done, total=total)

        rows = run(cases, seed, out, networks, workers, scheduler, show, errors.print, minutes)
    table = Table(
        box=SIMPLE_HEAD,
        title="Distance from the target while drawing the heart, RMS",
        title_justify="left",
    )
    for heading, _ in COLUMNS:
        table.add_column(heading, justify="right" if heading in MEASURED else "left")
    for row in rows:
        table.add_row(*(cell(row) for _, cell in COLUMNS))
    console.print(table)
    console.print(facts("", summary(rows)))
    say(f"table: {_written(out / 'table.md', rows, summary(rows))}")


def _written(path: Path, rows: Sequence[Row], figures: Sequence[tuple[str, str]]) -> Path:
    """The same in Markdown, which no narrow window cuts off."""
    headings = [heading for heading, _ in COLUMNS]
    lines = [headings, ["---:" if one in MEASURED else "---" for one in headings]]
    lines += [[cell(row).replace("\n", ", ") for _, cell in COLUMNS] for row in rows]
    text = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    text += "\n\n" + "\n".join(f"- {what}: {figure}" for what, figure in figures) + "\n"
    write_whole(path, text)
    return path


def _names(names: tuple[str, ...]) -> str:
    return "\n".join(names) or "nothing"


def _size(size_m: float) -> str:
    return "" if math.isnan(size_m) else millimetres(size_m)


def _verdict(row: Row) -> str:
    return row.failure or ("worse" if row.worse else "yes" if row.enough else "no")


COLUMNS: tuple[tuple[str, Callable[[Row], str]], ...] = (
    ("concealed", lambda row: _names(row.concealed)),
    ("found", lambda row: _names(row.found)),
    ("before", lambda row: _size(row.before_m)),
    ("after", lambda row: _size(row.after_m)),
    ("limit", lambda row: _size(row.limit_m)),
    ("above it", lambda row: _size(max(row.after_m - row.limit_m, 0.0))),
    ("sound robot", lambda row: _size(row.possible_m)),
    ("by network", lambda row: _size(row.network_after_m)),
    ("with tables", lambda row: _size(row.tables_m)),
    ("enough", _verdict),
)
MEASURED = ("before", "after", "limit", "above it", "sound robot", "by network", "with tables")
