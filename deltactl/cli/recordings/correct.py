"""`deltactl correct`: from recordings to a robot that draws better."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from deltactl.cli.output import console, facts, print_json, print_wrapped, say, waiting
from deltactl.cli.robot.jobs import JsonOption
from deltactl.foundation.extras import needs

if TYPE_CHECKING:
    from deltactl.repair.correct import Corrected
    from deltactl.repair.limit import Limit


def correct(
    recordings: Annotated[list[Path], typer.Argument(help="Recordings: .mcap, .csv, .parquet.")],
    robot: Annotated[str, typer.Option(help="The robot file used so far.")],
    out: Annotated[Path, typer.Option(help="Corrected robot file; its network goes beside it.")],
    all_of_them: Annotated[
        bool, typer.Option("--all", help="Also findings that are improbable or not certain.")
    ] = False,
    train: Annotated[
        bool, typer.Option(help="Train the network that belongs to the corrected file.")
    ] = True,
    tables: Annotated[
        Literal["none", "joints", "platform"],
        typer.Option(
            help="What has no name, as a table: of joints, or of the platform as well (if you know"
            " that it is the platform that is off, and not a sensor).",
        ),
    ] = "none",
    job: Annotated[
        str | None, typer.Option(help="Check this job with the corrected robot.")
    ] = None,
    json_out: JsonOption = False,
) -> None:
    """Diagnose recordings, write the corrected robot file, and train its network.

    Jobs need not be edited: run them with the corrected file.

    ```
    deltactl correct survey.mcap --robot zhao-2023.yaml --out mine.yaml
    deltactl run heart.yaml --robot mine.yaml
    ```
    """
    with waiting("loading", json_out), needs("diagnosis,training", "correct"):
        from deltactl.diagnosis.answer.tables import Tables
        from deltactl.repair.correct import correct as run
    from deltactl.firmware_py.named_files import find

    with waiting("reading", json_out) as show:
        found = run(recordings, find(robot), out, all_of_them, train, Tables(tables), show)
    limit = None if job is None else _limit_of(find(job), found)
    if json_out:
        possible = None if limit is None or isinstance(limit, str) else limit.as_json()
        print_json(_as_json(found) | {"limit": possible})
        return
    _say(found, all_of_them)
    if limit is not None:
        from deltactl.cli.robot.check import limit_rows

        console.print(facts(f"{job} may run with it", limit_rows(limit)))


def _limit_of(job: Path, found: Corrected) -> Limit | str:
    """Check a job with the corrected robot. Raises ConfigError, MotionError, NetworkError."""
    from deltactl.firmware_py.planner.plan import home_counts
    from deltactl.firmware_py.program.totals import program_of, summarise_program
    from deltactl.repair.limit import limit_of_program

    program = program_of(job, found.robot)
    summarise_program(program, home_counts(program.robot))
    return limit_of_program(program, job)


def _say(found: Corrected, all_of_them: bool) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.markup import escape
    from rich.table import Table

    from deltactl.diagnosis.report.next_run import supported

    table = Table(box=SIMPLE_HEAD, title="What is done about it", title_justify="left")
    table.add_column("known effect")
    table.add_column("compensated")
    for effect in found.coverage.effects:
        table.add_row(effect.says, effect.how or f"no: {effect.why_not}")
    for finding, why in found.held_back:
        table.add_row(finding.says, f"not written: {why}")
    if table.row_count:
        console.print(table)
    if not found.changed:
        say("nothing to correct: the robot file is as it was")
    say(f"robot file: {found.robot_file}")
    print_wrapped(escape(line) for line in supported(found.diagnosis, all_of_them))
    if found.network is not None:
        say(
            f"network:    {found.network} (error {found.network_error_deg:.2g} deg RMS), taken by"
            f" jobs that name {found.instead_of}"
        )


def _as_json(found: Corrected) -> dict[str, Any]:
    return {
        "robot": str(found.robot_file),
        "changed": found.changed,
        "effects": [effect.as_json() for effect in found.coverage.effects],
        "not_written": [
            {"effect": finding.effect, "component": finding.component, "why": why}
            for finding, why in found.held_back
        ],
        "network": None if found.network is None else str(found.network),
        "network_rmse_deg": found.network_error_deg,
        "instead_of": found.instead_of or None,
        "diagnosis": found.diagnosis.to_json(),
    }
