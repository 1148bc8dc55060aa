"""`deltactl prove`: how often the diagnosis is right about robots with something concealed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from deltactl.cli.output import console, errors, say
from deltactl.foundation.extras import needs


def register(app: typer.Typer) -> None:
    """Add the command of this file."""
    app.command()(prove)


def prove(
    out: Annotated[Path, typer.Option(help="Folder for results; an unfinished proof is resumed.")],
    cases: Annotated[int, typer.Option(help="How many cases.")] = 300,
    seed: Annotated[int, typer.Option(help="Draws the cases; any number.")] = 1,
    ties: Annotated[
        int | None, typer.Option(help="Pairs to settle by a proposed run; a tenth of the cases.")
    ] = None,
    more: Annotated[
        int, typer.Option(help="Further cases: four and five causes, more kinds of unknowns.")
    ] = 0,
    workers: Annotated[int, typer.Option(help="Processes here; 0 runs in this one.")] = 2,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, for more machines.")
    ] = None,
    minutes: Annotated[
        float,
        typer.Option(
            help="Minutes after which no case is begun; the table is of the finished ones."
        ),
    ] = float("inf"),
    repair: Annotated[
        bool,
        typer.Option("--repair", help="Correct each robot and compare what it draws instead."),
    ] = False,
    networks: Annotated[
        bool, typer.Option(help="With --repair: train each robot's network and run it, too.")
    ] = False,
) -> None:
    """Conceal effects in an independently simulated robot, diagnose blind, and count.

    ```
    deltactl prove --cases 300 --seed 7 --out proof-7
    deltactl prove --cases 300 --more 100 --seed 7 --out proof-7
    deltactl prove --repair --cases 40 --seed 1 --out repair-1
    deltactl prove --cases 3000 --seed 8 --out proof-8 --scheduler tcp://host:8786
    ```
    """
    if repair:
        from deltactl.cli.recordings.prove_repair import prove_repair

        prove_repair(cases, seed, out, networks, workers, scheduler, minutes)
        return
    with needs("proof", "prove"):
        from deltactl.proof.prove.campaign import prove as run
    tied = cases // 10 if ties is None else ties
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True) as bars:
        bar = bars.add_task("", total=cases + tied + more)

        def show(done: int, total: int, text: str) -> None:
            bars.update(bar, completed=done, total=total)
            if text:
                bars.console.print(text)

        outcome = run(cases, seed, out, tied, workers, scheduler, minutes, show, errors.print, more)
    table = Table(title=outcome.title, title_justify="left")
    for heading in ("figure", "goal", "reached", "95 % limits", "cases", "met"):
        table.add_column(heading)
    for row in outcome.rows:
        met = {True: "yes", False: "no", None: ""}[row.met]
        table.add_row(row.figure, row.goal, row.value, row.limits, str(row.cases), met)
    console.print(table)
    say(f"table: {outcome.table_file}")
    say(f"confusion matrix: {outcome.matrix_file}")
