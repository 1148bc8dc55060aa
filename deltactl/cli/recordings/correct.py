"""`deltactl correct`: from recordings to a robot that draws better."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from deltactl.cli.output import print_json, waiting
from deltactl.cli.recordings.diagnose import ColumnsOption, SetOption
from deltactl.cli.robot.jobs import JsonOption
from deltactl.foundation.extras import needs
from deltactl.foundation.one_screen import Part

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
        Literal["none", "joints", "sensors", "platform"],
        typer.Option(
            metavar="WHICH",
            help="What has no name, as a table: none, of joints, also of sensors, or of the"
            " platform instead (if you know that it is the platform that is off, and no sensor).",
        ),
    ] = "none",
    job: Annotated[
        str | None, typer.Option(help="Check this job with the corrected robot.")
    ] = None,
    json_out: JsonOption = False,
    set_columns: SetOption = None,
    columns: ColumnsOption = None,
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
        from deltactl.repair.correct import Asked
        from deltactl.repair.correct import correct as run
    from deltactl.cli.recordings.diagnosing import read_with
    from deltactl.firmware_py.named_files import find
    from deltactl.models.robot_files import load_with_effects

    robot_file = find(robot)
    read = read_with([*(columns or []), *(set_columns or [])], load_with_effects(robot_file))
    with waiting("reading", json_out) as show:
        asked = Asked(all_of_them, Tables(tables))
        found = run(recordings, robot_file, out, asked, train, show, read)
    limit = None if job is None else _limit_of(find(job), found)
    if json_out:
        possible = None if limit is None or isinstance(limit, str) else limit.as_json()
        print_json(_as_json(found) | {"limit": possible})
        return
    _say(found, all_of_them, [] if limit is None else _expected(job, limit))


def _limit_of(job: Path, found: Corrected) -> Limit | str:
    """Check a job with the corrected robot. Raises ConfigError, MotionError, NetworkError."""
    from deltactl.firmware_py.planner.plan import home_counts
    from deltactl.firmware_py.program.totals import program_of, summarise_program
    from deltactl.repair.limit import limit_of_program

    program = program_of(job, found.robot)
    summarise_program(program, home_counts(program.robot))
    return limit_of_program(program, job)


def _expected(job: str | None, limit: Limit | str) -> list[str]:
    from deltactl.cli.robot.check import limit_rows

    return [f"{job} with it: {name} {says}" for name, says in limit_rows(limit)]


def _say(found: Corrected, all_of_them: bool, expected: list[str]) -> None:
    """One screen: what was found, what is done about it, and the files. expected: of the job."""
    from deltactl.cli.recordings.diagnosing import Shown, print_answer
    from deltactl.diagnosis.report.next_run import done_part

    effects = [(one.says, one.how, one.why_not) for one in found.coverage.effects]
    after = [f"robot file: {found.robot_file}"]
    if not found.changed:
        after[0] += " (nothing to correct: it is as it was)"
    if found.network is not None:
        after.append(
            f"network:    {found.network} (error {found.network_error_deg:.2g} deg RMS), taken by"
            f" jobs that name {found.instead_of}"
        )
    done = done_part(effects, found.held_back)
    closing = [Part(expected, rank=1)]
    shown = Shown(found.diagnosis, found.robot, done=done, closing=closing, saved=all_of_them)
    print_answer(shown, after)


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
