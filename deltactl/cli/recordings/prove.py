"""`deltactl prove`: how often the diagnosis is right about machines with a hidden fault."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.table import Table

from deltactl.cli.output import console, errors, say
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs

if TYPE_CHECKING:
    from deltactl.proof.prove.resumable import Progress as Show

Machine = Literal["delta", "axis"]
Half = Literal["all", "even", "odd"]


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
    machine: Annotated[
        Machine, typer.Option(help="A delta, or single axes and range sensors.")
    ] = "delta",
    half: Annotated[
        Half,
        typer.Option(help="Of axes: only even seeds (for tuning) or only odd ones (for judging)."),
    ] = "all",
    practice: Annotated[
        Path | None,
        typer.Option(help="Of axes: a folder of cases with answers.json, scored beside."),
    ] = None,
) -> None:
    """Conceal effects in an independently simulated robot, diagnose blind, and count.

    ```
    deltactl prove --cases 300 --seed 7 --out proof-7
    deltactl prove --cases 300 --more 100 --seed 7 --out proof-7
    deltactl prove --repair --cases 40 --seed 1 --out repair-1
    deltactl prove --cases 3000 --seed 8 --out proof-8 --scheduler tcp://host:8786
    deltactl prove --machine axis --cases 200 --seed 1000 --out axes-1000
    deltactl prove --machine axis --cases 0 --practice practice_axes --out practice
    ```

    Each single axis has a seed of its own, from --seed on; the table shows even and odd ones side
    by side.
    """
    if machine == "axis":
        if repair or networks or more or ties:
            raise ConfigError(
                "--machine axis: --repair, --networks, --more and --ties are of deltas"
            )
        _prove_axes(cases, seed, half, out, practice, workers, scheduler, minutes)
        return
    if half != "all" or practice is not None:
        raise ConfigError("--half and --practice need --machine axis")
    if repair:
        from deltactl.cli.recordings.prove_repair import prove_repair

        prove_repair(cases, seed, out, networks, workers, scheduler, minutes)
        return
    with needs("proof", "prove"):
        from deltactl.proof.prove.campaign import prove as run
    tied = cases // 10 if ties is None else ties
    with _progress(cases + tied + more) as show:
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


def _prove_axes(
    cases: int,
    seed: int,
    half: Half,
    out: Path,
    practice: Path | None,
    count: int,
    scheduler: str | None,
    minutes: float,
) -> None:
    """Single axes and range sensors, even and odd seeds side by side."""
    with needs("proof", "prove"):
        from deltactl.proof.prove.axis_campaign import prove_axes
        from deltactl.proof.prove.axis_table import beside
        from deltactl.proof.prove.resumable import Means
    with _progress(cases) as show:
        means = Means(count, scheduler, minutes, show, errors.print)
        outcome = prove_axes(cases, seed, half, out, practice, means)
    table = Table(title=outcome.title, title_justify="left")
    for heading in ("figure", "goal", *outcome.columns):
        table.add_column(heading)
    for cells in beside(outcome.columns):
        table.add_row(*(cell.replace("**", "!") for cell in cells))
    console.print(table)
    say("a figure between ! and ! misses its goal; what went wrong is listed in the table's file")
    say(f"table: {outcome.table_file}")
    say(f"confusion matrix: {outcome.matrix_file}")


@contextmanager
def _progress(total: int) -> Iterator[Show]:
    """A bar on the terminal, with a line for each case that is finished."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True) as bars:
        bar = bars.add_task("", total=total)

        def show(done: int, all_: int, text: str) -> None:
            bars.update(bar, completed=done, total=all_)
            if text:
                bars.console.print(text)

        yield show
