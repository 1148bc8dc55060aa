"""`deltactl fleet`: many recordings of many robots, compared in one table and one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from deltactl.cli.help_screens import MORE
from deltactl.cli.output import bar, errors, say, warn
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs
from deltactl.foundation.printable import count

MOST_ERRORS = 6
"""Recordings that cannot be read of which the reason is shown beside the answer."""


def fleet(
    recordings: Annotated[
        list[str], typer.Argument(help="Recordings, or patterns such as 'runs/**/*.mcap'.")
    ],
    robots: Annotated[Path, typer.Option(help="Folder of robot files.")],
    out: Annotated[Path, typer.Option(help="Folder for table and page.")] = Path("fleet"),
    limit: Annotated[
        list[str] | None,
        typer.Option(help="The largest size allowed, as gear_backlash.width=0.01."),
    ] = None,
    workers: Annotated[int, typer.Option(min=0, help="Processes here; 0 is this one.")] = 2,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler.", rich_help_panel=MORE)
    ] = None,
    sisters: Annotated[
        bool,
        typer.Option(help="Findings on sister machines count.", rich_help_panel=MORE),
    ] = True,
) -> None:
    """Diagnose many recordings of many robots: one table and one page. A bad file costs one line.

    What is answered already is not diagnosed again.

    ```
    deltactl fleet 'runs/**/*.mcap' --robots robots/ --out fleet/
    deltactl fleet monday/ --robots robots/ --limit gear_backlash.width=0.01
    ```
    """
    known = _limits(limit or [])
    with needs("fleet", "deltactl fleet"):
        import deltactl.fleet.run as run

    unreadable = 0
    with bar("looking for recordings") as draw:

        def progress(done: int, of: int, row: dict[str, Any]) -> None:
            nonlocal unreadable
            unreadable += "error" in row
            if "error" in row and unreadable <= MOST_ERRORS:
                errors.print(row["error"], soft_wrap=True)
            draw(done, of, Path(row["recording"]).name)

        where = run.Workers(workers, scheduler)
        rows = run.diagnose_fleet(recordings, robots, out, where, known, progress, sisters)
    bad = sum("error" in row for row in rows)
    if unreadable > MOST_ERRORS:
        warn(f"and {unreadable - MOST_ERRORS} more that cannot be read: see the table")
    missing = sum(row.get("verdict", "nothing_missing") != "nothing_missing" for row in rows)
    say(f"{count(len(rows), 'recording')}: {missing} with a model error, {bad} unreadable")
    say(f"page:  {out / run.PAGE}\ntable: {out / run.TABLE}")
    if bad == len(rows):
        warn("no recording could be read")


def _limits(given: list[str]) -> dict[str, float]:
    found = {}
    for text in given:
        name, _, value = text.partition("=")
        try:
            found[name] = float(value)
        except ValueError:
            value = ""
        if name.count(".") != 1 or not value:
            raise ConfigError(f"--limit {text}: write it as gear_backlash.width=0.01")
    return found
