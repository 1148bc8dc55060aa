"""`deltactl heal`: the robot repairs itself, or says why it cannot."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deltactl.cli.help_screens import MORE
from deltactl.cli.output import (
    NO_ROBOT,
    duration,
    errors,
    print_json,
    say,
    screen_width,
    tell,
    waiting,
    warn,
    wrapped,
)
from deltactl.cli.robot.jobs import JsonOption
from deltactl.foundation.errors import ServiceError
from deltactl.foundation.extras import needs

if TYPE_CHECKING:
    from deltactl.repair.patients import Patient

MOST_LINES = 25
NOT_HEALED = 1
"""Exit status where the goal is missed, or a correction was found and is not in force."""


def heal(
    robot: Annotated[str, typer.Argument(help="Robot file; corrected in place.")],
    job: Annotated[
        str | None,
        typer.Option(help="The job that is drawn before and after; else the heart of the demo."),
    ] = None,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="On a simulated robot in this process, no daemon.")
    ] = False,
    go_on: Annotated[
        bool,
        typer.Option(
            "--continue", help="After an interruption, or after the work that needed a hand."
        ),
    ] = False,
    undo: Annotated[
        bool, typer.Option("--undo", help="Put back the robot file from before the correction.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder for what is recorded; else heal-NAME here.")
    ] = None,
    minutes: Annotated[
        float | None,
        typer.Option(
            min=0.2, max=60.0, help="Length of the survey; else chosen by noise and accuracy."
        ),
    ] = None,
    goal: Annotated[
        float | None,
        typer.Option(
            min=0.001, help="mm RMS, near enough; else 1.3 times what is possible, or 0.15."
        ),
    ] = None,
    json_out: JsonOption = False,
    socket: Annotated[
        Path | None, typer.Option(help="Socket of the daemon.", rich_help_panel=MORE)
    ] = None,
) -> None:
    """Survey, diagnose and correct a robot; keep the correction only if it draws better.

    The robot file is replaced at the end, after a job that took no part was drawn nearer to its
    path by more than the sensors' noise. Exit status 1: the goal was missed, or a correction was
    found and not kept.

    ```
    deltactl heal mine.yaml
    deltactl heal mine.yaml --job heart.yaml --simulate
    deltactl heal mine.yaml --continue
    deltactl heal mine.yaml --undo
    ```
    """
    with waiting("loading", json_out), needs("diagnosis,training", "heal"):
        from deltactl.repair.heal import Healer, Order
        from deltactl.repair.heal_answer import HEALED, NOTHING
        from deltactl.repair.healing_state import undo as put_back
    from deltactl.firmware_py.named_files import JOB_KEY, ROBOT_KEY, find

    path = find(robot, key=ROBOT_KEY)
    folder = out or Path(f"heal-{path.stem}")
    if undo:
        changed = put_back(folder, path)
        if json_out:
            print_json({"undone": changed, "robot": str(path)})
            return
        say(f"{path}: {'as before the correction again' if changed else 'nothing to undo'}")
        return
    drawn = None if job is None else find(job, key=JOB_KEY)
    order = Order(path, drawn, folder, minutes, go_on, None if goal is None else 1e-3 * goal)
    with _patient(order.robot_file, folder, simulate, socket) as patient:
        answer = Healer(order, patient, _progress(json_out)).heal()
    if json_out:
        print_json(answer)
    else:
        for line in screen(answer, robot):
            say(line)
    if answer["outcome"] not in (HEALED, NOTHING):
        raise typer.Exit(NOT_HEALED)


@contextmanager
def _patient(
    robot_file: Path, folder: Path, simulate: bool, socket: Path | None
) -> Iterator[Patient]:
    from deltactl.firmware_py.daemon.client import daemon_answers
    from deltactl.firmware_py.machine import is_raspberry_pi
    from deltactl.repair.patients import DaemonPatient, SimulatedPatient

    if not simulate and daemon_answers(socket):
        yield DaemonPatient(socket, robot_file)
        return
    if not simulate:
        if socket is not None or is_raspberry_pi():
            raise ServiceError("no daemon answers; start it, or use --simulate")
        tell(NO_ROBOT.format("healing"), errors)
    yield SimulatedPatient(folder)


def _progress(quiet: bool) -> Callable[[str], None]:
    """A line for each step on standard error, with the time since the first."""
    begun_s = time.monotonic()

    def show(text: str) -> None:
        if not quiet:
            warn(f"{duration(time.monotonic() - begun_s):>12}  {text}")

    return show


def screen(answer: dict[str, Any], robot: str) -> list[str]:
    """The answer on one screen: at most 25 lines of the window's width."""
    from rich.text import Text

    from deltactl.repair.heal_answer import lines_of

    command = f"deltactl heal {robot}"
    lines = lines_of(answer, f"{command} --continue", f"{command} --undo")
    lines.append(f"report: {answer['report']}")
    width = screen_width()
    shown = [part.plain for line in lines for part in wrapped(Text(line), width)]
    if len(shown) > MOST_LINES:
        shown = [*shown[: MOST_LINES - 1], "the rest is in --json"]
    return shown
