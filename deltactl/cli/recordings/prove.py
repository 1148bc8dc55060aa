"""`deltactl demo prove`: how often the diagnosis is right about machines with a hidden fault."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.box import SIMPLE_HEAD
from rich.table import Table

from deltactl.cli.help_screens import MORE
from deltactl.cli.output import bar, console, errors, facts, millimetres, say
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs
from deltactl.foundation.plain_file import write_whole

if TYPE_CHECKING:
    from deltactl.proof.prove.resumable import Means
    from deltactl.proof.prove.resumable import Progress as Show
    from deltactl.repair.campaign import Row


Machine = Literal["delta", "axis"]
Half = Literal["all", "even", "odd"]


def prove(
    out: Annotated[Path, typer.Option(help="Folder for results; an unfinished proof is resumed.")],
    cases: Annotated[int, typer.Option(help="How many cases.")] = 300,
    seed: Annotated[int, typer.Option(help="Draws the cases; any number.")] = 1,
    ties: Annotated[
        int | None,
        typer.Option(
            help="Pairs to settle by a proposed run; a tenth of the cases.", rich_help_panel=MORE
        ),
    ] = None,
    more: Annotated[
        int,
        typer.Option(
            help="Further cases: four and five causes, more kinds of unknowns.",
            rich_help_panel=MORE,
        ),
    ] = 0,
    workers: Annotated[int, typer.Option(help="Processes here; 0 runs in this one.")] = 2,
    scheduler: Annotated[
        str | None,
        typer.Option(help="Address of a Dask scheduler, for more machines.", rich_help_panel=MORE),
    ] = None,
    minutes: Annotated[
        float,
        typer.Option(
            help="Minutes after which no case is begun; the table is of the finished ones.",
            rich_help_panel=MORE,
        ),
    ] = float("inf"),
    repair: Annotated[
        bool,
        typer.Option("--repair", help="Correct each robot and compare what it draws instead."),
    ] = False,
    heal: Annotated[
        bool,
        typer.Option("--heal", help="Let each robot heal itself and see what it truly draws."),
    ] = False,
    networks: Annotated[
        bool,
        typer.Option(
            help="With --repair: train each robot's network and run it, too.", rich_help_panel=MORE
        ),
    ] = False,
    machine: Annotated[
        Machine, typer.Option(help="A delta, or single axes and range sensors.")
    ] = "delta",
    half: Annotated[
        Half,
        typer.Option(
            help="For axes: only even seeds (for tuning) or only odd ones (for judging).",
            rich_help_panel=MORE,
        ),
    ] = "all",
    practice: Annotated[
        Path | None,
        typer.Option(
            help="For axes: a folder of cases with answers.json, scored beside.",
            rich_help_panel=MORE,
        ),
    ] = None,
) -> None:
    """Hide effects in an independently simulated robot, diagnose blind, and count.

    ```
    deltactl demo prove --cases 300 --seed 7 --out proof-7
    deltactl demo prove --cases 300 --more 100 --seed 7 --out proof-7
    deltactl demo prove --repair --cases 40 --seed 1 --out repair-1
    deltactl demo prove --heal --cases 48 --seed 1 --out heal-1
    deltactl demo prove --cases 3000 --seed 8 --out p --scheduler tcp://pc:8786
    deltactl demo prove --machine axis --cases 200 --seed 1000 --out axes-1000
    deltactl demo prove --machine axis --cases 0 --practice drawn --out axes
    ```

    Each single axis has a seed of its own, from --seed on; the table shows even and odd ones side
    by side.
    """
    if machine == "axis":
        if repair or heal or networks or more or ties:
            raise ConfigError(
                "--machine axis: --repair, --heal, --networks, --more and --ties are of deltas"
            )
    elif half != "all" or practice is not None:
        raise ConfigError("--half and --practice need --machine axis")
    with needs("proof", "prove"):
        from deltactl.proof.prove.campaign import prove as run
        from deltactl.proof.prove.resumable import Means
    where = partial(Means, workers, scheduler, minutes)
    if machine == "axis":
        _prove_axes(cases, seed, half, out, practice, where)
        return
    if heal:
        prove_heal(cases, seed, out, where)
        return
    if repair:
        prove_repair(cases, seed, out, networks, where)
        return
    tied = cases // 10 if ties is None else ties
    with bar(total=cases + tied + more) as draw:
        means = where(_with_lines(draw), errors.print)
        outcome = run(cases, seed, out, tied, more, means)
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
    where: Callable[..., Means],
) -> None:
    """Single axes and range sensors, even and odd seeds side by side."""
    with needs("proof", "prove"):
        from deltactl.proof.prove.axis_campaign import prove_axes
        from deltactl.proof.prove.axis_score import beside
    with bar(total=cases) as draw:
        means = where(_with_lines(draw), errors.print)
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


def _with_lines(draw: Show) -> Show:
    """The bar, and a line for each case that is finished."""

    def show(done: int, of: int, text: str) -> None:
        draw(done, of, "")
        if text:
            errors.print(text)

    return show


def prove_repair(
    cases: int, seed: int, out: Path, networks: bool, where: Callable[..., Means]
) -> None:
    """Run the cases and print the table."""
    with needs("proof", "prove"):
        from deltactl.repair.campaign import prove_repair as run
        from deltactl.repair.campaign import summary
    with bar(total=cases) as draw:
        rows = run(cases, seed, out, networks, where(draw, errors.print))
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


def prove_heal(cases: int, seed: int, out: Path, where: Callable[..., Means]) -> None:
    """Run the cases and print the table."""
    with needs("proof", "prove"):
        from deltactl.repair.heal_campaign import enough, figures
        from deltactl.repair.heal_campaign import prove_heal as run
    with bar(total=cases) as draw:
        rows = run(cases, seed, out, where(draw, errors.print))
    table = Table(box=SIMPLE_HEAD, title="True distance from the target, RMS", title_justify="left")
    for heading in ("hidden", "outcome", "before", "after", "enough"):
        table.add_column(heading)
    for row in rows:
        sizes = (millimetres(row[name]) for name in ("before_m", "after_m"))
        good = "yes" if enough(row) else "no"
        table.add_row(_names(tuple(row["hidden"])), row["outcome"], *sizes, good)
    console.print(table)
    console.print(facts("", figures(rows)))


def _written(path: Path, rows: Sequence[Row], figures: Sequence[tuple[str, str]]) -> Path:
    """The same in Markdown, which no narrow window cuts off."""
    headings = [heading for heading, _ in COLUMNS]
    lines = [headings, ["---:" if heading in MEASURED else "---" for heading in headings]]
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
    ("hidden", lambda row: _names(row.hidden)),
    ("found", lambda row: _names(row.found)),
    ("before", lambda row: _size(row.before_m)),
    ("after", lambda row: _size(row.after_m)),
    ("limit", lambda row: _size(row.limit_m)),
    ("above it", lambda row: _size(max(row.after_m - row.limit_m, 0.0))),
    ("healthy robot", lambda row: _size(row.possible_m)),
    ("by network", lambda row: _size(row.network_after_m)),
    ("with tables", lambda row: _size(row.tables_m)),
    ("enough", _verdict),
)
MEASURED = ("before", "after", "limit", "above it", "healthy robot", "by network", "with tables")
