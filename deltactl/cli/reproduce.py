"""`deltactl network reproduce`: a paper's experiments repeated, beside its printed figures."""

from __future__ import annotations

import time
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deltactl.cli.output import errors, say
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.extras import needs

if TYPE_CHECKING:
    from deltactl.reproduction.outcome import Outcome


class Paper(StrEnum):
    """Which paper."""

    ZHAO = "zhao-2023"
    UZUNOVIC = "uzunovic-2013"


def reproduce(
    paper: Annotated[Paper, typer.Argument(help="Whose experiments.")],
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the report (zhao-2023: data and networks there are reused)."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A short version, to see that it runs.")
    ] = False,
    diagnosed: Annotated[
        bool,
        typer.Option(
            "--diagnosed", help="zhao-2023: only the table of the diagnosed and corrected robot."
        ),
    ] = False,
) -> None:
    """Do a paper's experiments on a simulated robot; tables and one HTML report.

    ```
    deltactl network reproduce zhao-2023 --out zhao
    deltactl network reproduce zhao-2023 --out zhao --diagnosed
    deltactl network reproduce uzunovic-2013 --quick
    ```
    """
    folder = out or Path("reproduced") / f"{paper.value}{'-quick' if quick else ''}"
    started_s = time.monotonic()

    def tell(text: str) -> None:
        errors.print(f"{time.monotonic() - started_s:6.0f} s  {text}", soft_wrap=True)

    if diagnosed:
        with needs("proof,training", "network reproduce"):
            from deltactl.reproduction.zhao_2023.run import diagnosed_only
        if paper is not Paper.ZHAO:
            raise ConfigError("--diagnosed is a table of zhao-2023; leave it out, or name that")
        say(diagnosed_only(folder, quick, tell).text())
        return
    with needs("proof,training", "network reproduce"):
        outcome = _run(paper, folder, quick, tell)
    for sheet in outcome.sheets:
        say(sheet.text())
    say(f"report: {outcome.report}")
    say(f"tables: {outcome.tables}")


def _run(paper: Paper, folder: Path, quick: bool, tell: Callable[[str], None]) -> Outcome:
    if paper is Paper.ZHAO:
        from deltactl.reproduction.zhao_2023 import run as zhao

        return zhao.reproduce(folder, quick, tell)
    from deltactl.reproduction.uzunovic_2013 import run as uzunovic

    return uzunovic.reproduce(folder, quick, tell)
