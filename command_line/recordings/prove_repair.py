"""`deltactl prove --repair`: what correcting a robot gains, case by case."""

from __future__ import annotations

from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn
from rich.table import Table

from command_line.output import console, errors, facts, millimetres
from foundation.extras import needs


def prove_repair(cases: int, seed: int, out: Path, workers: int, scheduler: str | None) -> None:
    """Run the cases and print the table."""
    with needs("proof", "prove"):
        from repair.campaign import prove_repair as run
        from repair.campaign import summary
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True) as bars:
        bar = bars.add_task("", total=cases)

        def show(done: int, total: int) -> None:
            bars.update(bar, completed=done, total=total)

        rows = run(cases, seed, out, workers, scheduler, show, errors.print)
    table = Table(
        box=SIMPLE_HEAD,
        title="Distance from the target while drawing the heart, RMS",
        title_justify="left",
    )
    for heading in ("concealed", "found", "before", "after", "possible", "enough"):
        table.add_column(heading, justify="right" if heading in MEASURED else "left")
    for row in rows:
        verdict = row.failure or ("worse" if row.worse else "yes" if row.enough else "no")
        table.add_row(
            "\n".join(row.concealed) or "nothing",
            "\n".join(row.found) or "nothing",
            *(millimetres(value) for value in (row.before_m, row.after_m, row.possible_m)),
            verdict,
        )
    console.print(table)
    console.print(facts("", summary(rows)))


MEASURED = ("before", "after", "possible")
