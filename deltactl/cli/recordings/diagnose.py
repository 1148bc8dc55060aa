"""`deltactl inspect` and `deltactl diagnose`: what a recording holds, and what it says."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.file_arguments import ForceOption, refuse_existing, refuse_other_page
from deltactl.cli.help_screens import MORE
from deltactl.cli.output import waiting
from deltactl.cli.robot.jobs import JsonOption

ColumnsOption = Annotated[
    list[str] | None,
    typer.Option(
        help="Mapping file for other columns and units, or NAME=COLUMN[unit].", rich_help_panel=MORE
    ),
]
SetOption = Annotated[
    list[str] | None, typer.Option("--set", help="One column of a mapping, as t=time_ms*0.001.")
]


def inspect(
    recordings: Annotated[list[Path], typer.Argument(help="Tables or recordings.")],
    robot: Annotated[
        str | None, typer.Option(help="Robot file for the command that is printed.")
    ] = None,
    set_columns: SetOption = None,
    save_columns: Annotated[Path | None, typer.Option(help="Write the mapping file here.")] = None,
    json_out: JsonOption = False,
    force: ForceOption = False,
    columns: ColumnsOption = None,
) -> None:
    """Show what tables contain, and which command diagnoses them.

    ```
    deltactl inspect log.csv
    deltactl inspect log.csv --set "position=angle[deg]"
    deltactl inspect log.csv --save-columns log-columns.yaml
    ```
    """
    from deltactl.cli.recordings.inspect import inspect_recordings

    refuse_existing(force, save_columns)
    known = [*(columns or []), *(set_columns or [])]
    inspect_recordings(recordings, robot, save_columns, json_out, known)


def diagnose(
    recordings: Annotated[list[Path], typer.Argument(help="Recordings: .mcap, .csv, .parquet.")],
    robot: Annotated[
        str | None, typer.Option(help="Robot file: the machine as it should be.")
    ] = None,
    set_columns: SetOption = None,
    holdout: Annotated[
        list[Path] | None,
        typer.Option(help="Another run of the same robot, to test the answer on."),
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write an HTML report here.")] = None,
    json_file: Annotated[
        Path | None,
        typer.Option("--json", help="Write the answer here as JSON, - for the terminal."),
    ] = None,
    save_robot: Annotated[
        Path | None,
        typer.Option(help="Write here the robot file with what is certain to be corrected."),
    ] = None,
    next_job: Annotated[
        Path | None,
        typer.Option(help="Write the job that would separate tied explanations here."),
    ] = None,
    force: ForceOption = False,
    save_all: Annotated[
        bool,
        typer.Option(
            "--all",
            help="With --save-robot: also findings that are improbable or not certain.",
            rich_help_panel=MORE,
        ),
    ] = False,
    columns: ColumnsOption = None,
) -> None:
    """Compare recordings with the robot file: what is missing, where, how sure.

    ```
    deltactl diagnose run.csv.gz --robot zhao-2023.yaml
    deltactl diagnose a.mcap --robot my.yaml --holdout b.mcap --report why.html
    deltactl diagnose axis.csv --robot axis.yaml --set "position=angle[deg]"
    ```
    """
    if robot is None:
        raise typer.BadParameter(
            "say which robot file describes the machine, or look at the data with"
            f" 'deltactl inspect {recordings[0]}'",
            param_hint="--robot",
        )
    if save_all and save_robot is None:
        raise typer.BadParameter("add --save-robot FILE, which it is for", param_hint="--all")
    with waiting("loading", str(json_file) == "-"):
        from deltactl.cli.recordings.diagnosing import Wanted, diagnose_recordings

    refuse_existing(force, json_file, report, save_robot, next_job)
    refuse_other_page(report)
    wanted = Wanted(json_file, report, save_robot, save_all, next_job, force)
    known = [*(columns or []), *(set_columns or [])]
    diagnose_recordings(recordings, robot, holdout or [], known, wanted)
