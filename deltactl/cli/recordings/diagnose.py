"""Commands that need no robot: diagnose, install, version."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.file_arguments import ForceOption, refuse_existing, refuse_other_page
from deltactl.cli.output import waiting


def diagnose(
    recordings: Annotated[
        list[Path] | None, typer.Argument(help="Recordings: .mcap, .csv, .parquet.")
    ] = None,
    robot: Annotated[
        str | None, typer.Option(help="Robot file: the machine as it should be.")
    ] = None,
    look: Annotated[
        bool,
        typer.Option(
            "--inspect", help="Only show what the tables contain, and which command reads them."
        ),
    ] = False,
    holdout: Annotated[
        list[Path] | None,
        typer.Option(help="Another run of the same robot, to test the answer on."),
    ] = None,
    json_file: Annotated[
        Path | None,
        typer.Option("--json", help="Write the answer here as JSON, - for the terminal."),
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write an HTML report here.")] = None,
    save_robot: Annotated[
        Path | None,
        typer.Option(help="Write here the robot file with what is certain to be corrected."),
    ] = None,
    save_all: Annotated[
        bool,
        typer.Option(
            "--all", help="With --save-robot: also findings that are improbable or not certain."
        ),
    ] = False,
    next_job: Annotated[
        Path | None,
        typer.Option(help="Write the job that would separate tied explanations here."),
    ] = None,
    columns: Annotated[
        list[str] | None,
        typer.Option(help="Mapping file for other columns and units, or NAME=COLUMN[unit]."),
    ] = None,
    set_columns: Annotated[
        list[str] | None, typer.Option("--set", help="One column of a mapping, as t=time_ms*0.001.")
    ] = None,
    save_columns: Annotated[
        Path | None, typer.Option(help="With --inspect: write the mapping file here.")
    ] = None,
    thorough: Annotated[
        bool,
        typer.Option(
            "--thorough", help="Search without the limit of work, if the answer ended early."
        ),
    ] = False,
    force: ForceOption = False,
    fleet: Annotated[
        str | None,
        typer.Option(help="Many recordings instead, by a pattern such as 'runs/**/*.mcap'."),
    ] = None,
    robots: Annotated[
        Path | None, typer.Option(help="With --fleet: folder of robot files.")
    ] = None,
    out: Annotated[Path, typer.Option(help="With --fleet: folder for table and page.")] = Path(
        "fleet"
    ),
    workers: Annotated[
        int, typer.Option(min=0, help="With --fleet: processes here; 0 is this one.")
    ] = 2,
    scheduler: Annotated[
        str | None, typer.Option(help="With --fleet: address of a Dask scheduler.")
    ] = None,
    limit: Annotated[
        list[str] | None,
        typer.Option(help="With --fleet: the largest size allowed, as gear_backlash.width=0.01."),
    ] = None,
    sisters: Annotated[
        bool, typer.Option(help="With --fleet: findings on sister machines count.")
    ] = True,
) -> None:
    """Compare recordings with the robot file: what is missing, where, how sure.

    ```
    deltactl diagnose run.csv.gz --robot zhao-2023.yaml
    deltactl diagnose a.mcap --robot zhao-2023.yaml --holdout b.mcap --report why.html
    deltactl diagnose axis.csv --robot axis.yaml --set t=ms*0.001 --set "position=angle[deg]"
    deltactl diagnose log.csv --inspect
    deltactl diagnose --fleet 'runs/**/*.mcap' --robots robots/ --out fleet/
    ```
    """
    if fleet is not None:
        from deltactl.cli.recordings.diagnosing import diagnose_many

        diagnose_many(fleet, robots, out, workers, scheduler, limit or [], sisters)
        return
    if not recordings:
        raise typer.BadParameter("name at least one, or many with --fleet", param_hint="RECORDINGS")
    if look:
        from deltactl.cli.recordings.inspect import inspect_recordings

        refuse_existing(force, save_columns)
        known = [*(columns or []), *(set_columns or [])]
        inspect_recordings(recordings, robot, save_columns, json_file is not None, known)
        return
    if robot is None:
        meant = f"did you mean --robot {robots}? (--robots goes with --fleet); " if robots else ""
        raise typer.BadParameter(
            f"{meant}say which robot file describes the machine, or look at the data with"
            " --inspect",
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
    diagnose_recordings(recordings, robot, holdout or [], known, wanted, thorough)
