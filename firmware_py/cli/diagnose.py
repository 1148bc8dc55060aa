"""`deltactl diagnose`: what the model of a robot leaves out."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from firmware_py.cli.output import console, errors
from firmware_py.robot_file import find


def diagnose_recordings(
    recordings: list[Path],
    robot: str,
    holdout: list[Path],
    json_file: Path | None,
    report: Path | None,
    save_robot: Path | None,
) -> None:
    """Diagnose, print what was found in plain sentences, and write what was asked for."""
    from diagnosis.command import diagnose

    quiet = json_file is not None and str(json_file) == "-"
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=errors, transient=True, disable=quiet) as progress:
        bar = progress.add_task("reading")

        def show(text: str) -> None:
            progress.update(bar, description=text)

        step: Callable[[str], None] = show
        answer = diagnose(
            recordings,
            find(robot),
            holdout=holdout,
            json_out=None if quiet else json_file,
            report_out=report,
            save_robot=save_robot,
            progress=step,
        )
    if quiet:
        print(json.dumps(answer.to_json(), indent=2))
        return
    from diagnosis.report.summary import summary_lines

    for line in summary_lines(answer):
        console.print(line)
    for name, path in (("report", report), ("answer", json_file), ("robot file", save_robot)):
        if path is not None:
            console.print(f"{name}: {path}")
