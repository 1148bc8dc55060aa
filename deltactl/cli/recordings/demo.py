"""`deltactl demo`: a robot with hidden faults is recorded, diagnosed and corrected."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deltactl.cli.file_arguments import refuse_existing
from deltactl.cli.output import console, millimetres, print_json, say, waiting, warn
from deltactl.cli.robot.jobs import JsonOption
from deltactl.foundation.extras import needs
from deltactl.foundation.plain_file import write_whole

if TYPE_CHECKING:
    from deltactl.repair.demonstration import Demonstration

USUAL = "home_offset,gear_backlash"
PAGE, ABOUT = "demo.html", "about.txt"
OURS = "Made by 'deltactl demo'. The next demonstration in this folder replaces what is here.\n"


def demo(
    ctx: typer.Context,
    hide: Annotated[
        str, typer.Option(help="Effects to hide, separated by commas; '' for none.")
    ] = USUAL,
    seed: Annotated[int, typer.Option(min=0, help="Draws components and sizes.")] = 3,
    unknown: Annotated[
        bool, typer.Option("--unknown", help="Hide something that has no name as well.")
    ] = False,
    job: Annotated[str, typer.Option(help="The job that is drawn.")] = "demo-heart.yaml",
    minutes: Annotated[
        float, typer.Option(min=0.5, max=10.0, help="Length of the survey that is recorded.")
    ] = 2.0,
    out: Annotated[Path, typer.Option(help="Folder for page, recording, robot file.")] = Path(
        "demo"
    ),
    force: Annotated[
        bool, typer.Option("--force", help="Overwrite files that no demonstration made.")
    ] = False,
    json_out: JsonOption = False,
) -> None:
    """A robot with hidden faults draws a heart, is diagnosed, corrected, and draws again.

    The robot is a MuJoCo model that shares nothing with what explains it. Takes about a minute.
    The next demonstration in the same folder replaces this one.

    ```
    deltactl demo
    deltactl demo --hide joint_friction,upper_arm_length --seed 1
    deltactl demo --hide "" --unknown
    ```
    """
    if ctx.invoked_subcommand is not None:
        return
    with waiting("loading", json_out), needs("proof", "demo"):
        from deltactl.repair.demonstration import (
            CORRECTED,
            RECORDING,
            HiddenFaults,
            demonstrate,
            write_page,
        )
    from deltactl.firmware_py.job_file import load_job
    from deltactl.firmware_py.named_files import find

    path = find(job)
    robot = load_job(path).robot
    robot_file = find(robot, beside=path)
    effects = [name.strip() for name in hide.split(",") if name.strip()]
    replaces = make_room(out, (PAGE, RECORDING, CORRECTED), force)
    if replaces:
        warn(f"replacing the demonstration in {out}; --out FOLDER keeps both")
    with waiting("building the robot", json_out) as show:
        hidden = HiddenFaults(effects, seed, unknown)
        shown = demonstrate(path, robot_file, out, hidden, 60.0 * minutes, show)
    page = out / PAGE
    write_page(shown, page)
    if json_out:
        print_json(_as_json(shown, page))
        return
    _say(shown)
    say(f"page:       {page}")
    say(f"robot file: {shown.corrected}")
    say(f"recording:  {shown.recording}")
    say(f"diagnosis:  deltactl diagnose {shown.recording} --robot {robot}")


def make_room(out: Path, names: Sequence[str], force: bool) -> bool:
    """Make the folder, marked as that of a demonstration; True where one in it is replaced.

    names: of the files it leaves. Raises ConfigError for files of these names that no demonstration
    made, unless forced.
    """
    mark = out / ABOUT
    ours = mark.is_file() and mark.read_bytes() == OURS.encode()
    there = [file for name in (*names, ABOUT) if (file := out / name).exists()]
    if there and not ours:
        refuse_existing(force, *there)
    out.mkdir(parents=True, exist_ok=True)
    write_whole(mark, OURS)
    return ours and len(there) > 1


def _say(shown: Demonstration) -> None:
    from deltactl.diagnosis.report.finding import other_causes
    from deltactl.diagnosis.report.names import effect

    for answer in shown.answers:
        say(f"hidden:     {effect(answer.effect, answer.where)}")
    for finding in shown.diagnosis.findings:
        instead = f", or {other_causes(finding)}" if finding.alternatives else ""
        say(f"found:      {finding.says}{instead}")
    if not shown.diagnosis.findings:
        say("found:      nothing")
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, title="Distance from the target", title_justify="left")
    for heading in ("", "RMS", "largest"):
        table.add_column(heading, justify="right" if heading else "left")
    runs = (("before", shown.before), ("after", shown.after), ("healthy robot", shown.possible))
    for name, run in runs:
        table.add_row(name, millimetres(run.rms_m), millimetres(run.worst_m))
    console.print(table)
    if shown.limit is not None:
        say(f"expected of this robot: about {millimetres(shown.limit.rms_m)} RMS")
    from deltactl.cli.robot.check import say_covered

    say_covered(shown.coverage)
    for finding, why in shown.held_back:
        say(f"not written: {finding.effect} on {finding.component}: {why}")


def _as_json(shown: Demonstration, page: Path) -> dict[str, Any]:
    return {
        "concealed": [answer.answer() for answer in shown.answers],
        "found": [finding.model_dump(mode="json") for finding in shown.diagnosis.findings],
        "before_rms_m": shown.before.rms_m,
        "after_rms_m": shown.after.rms_m,
        "possible_rms_m": shown.possible.rms_m,
        "limit": None if shown.limit is None else shown.limit.as_json(),
        "effects": [effect.as_json() for effect in shown.coverage.effects],
        "not_written": [
            {"effect": finding.effect, "component": finding.component, "why": why}
            for finding, why in shown.held_back
        ],
        "page": str(page),
        "robot": str(shown.corrected),
        "recording": str(shown.recording),
    }
