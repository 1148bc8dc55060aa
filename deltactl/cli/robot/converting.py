"""Commands for paths of other programs and places of the robot: teach, convert."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.robot.jobs import SocketOption
from deltactl.cli.robot.moves import SpeedOption, platform_m
from deltactl.firmware_py.importing.drawn import CORNER_MM


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    app.command()(teach)
    app.command()(convert)


def teach(
    points: Annotated[Path, typer.Argument(help="Table to add to (.csv); created if missing.")],
    dwell: Annotated[float, typer.Option(min=0.0, help="Wait there, s.")] = 0.0,
    socket: SocketOption = None,
) -> None:
    """Save the platform's position as the next point of a table; `convert` turns it into a job.

    ```
    deltactl teach pick.csv
    deltactl convert pick.csv pick.yaml --robot zhao-2023.yaml
    ```
    """
    from deltactl.cli.output import say
    from deltactl.firmware_py.importing.teaching import add_point

    place_m = platform_m(socket)
    add_point(points, place_m, dwell)
    say(f"{points}: {', '.join(f'{1e3 * value:z.4f}' for value in place_m)} mm")


def convert(
    source: Annotated[Path, typer.Argument(help="G-code, or a table of points (.csv, mm).")],
    job: Annotated[Path, typer.Argument(help="Job file to write (.yaml).")],
    robot: Annotated[str, typer.Option(help="Robot file that the job is for.")],
    speed: SpeedOption = 50.0,
    corner: Annotated[
        float, typer.Option(min=0.0, max=100.0, help="May cut corners by so many mm; 0 stops.")
    ] = CORNER_MM,
    spline: Annotated[
        bool, typer.Option("--spline", help="A smooth curve through the points of a table.")
    ] = False,
    origin: Annotated[
        str, typer.Option(help="Where the file's 0 0 0 is in the robot's frame, mm.")
    ] = "0 0 0",
    code: Annotated[
        list[str] | None,
        typer.Option(
            help='What a code of G-code means: "M3=OUTPUT on", "G28=X Y Z", G4=s, M6=pause.'
        ),
    ] = None,
    skip: Annotated[
        list[str] | None,
        typer.Option(help="Leave out a code of G-code (G28, M600), or a column of a table."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")] = False,
) -> None:
    """Turn G-code or a table of points into a job, and check it.

    ```
    deltactl convert part.gcode part.yaml --robot zhao-2023.yaml --origin "0 0 -450"
    deltactl convert slice.gcode slice.yaml --robot zhao-2023.yaml --origin "0 0 -450" --skip G28
    deltactl convert points.csv path.yaml --robot zhao-2023.yaml --corner 1
    deltactl convert points.csv path.yaml --robot zhao-2023.yaml --spline
    ```
    """
    from deltactl.cli.output import say, warn
    from deltactl.cli.overwriting import written_if_right
    from deltactl.cli.robot.check import show_check
    from deltactl.firmware_py.describing.questions import numbers
    from deltactl.firmware_py.importing.by_line import checked_job, told_by_line
    from deltactl.firmware_py.importing.drawn import TABLES, held, job_text, rounded
    from deltactl.firmware_py.importing.gcode import read_gcode
    from deltactl.firmware_py.importing.gcode_meanings import meanings_of
    from deltactl.firmware_py.importing.origin import with_an_origin
    from deltactl.firmware_py.importing.points_table import read_points
    from deltactl.firmware_py.kinematics_of_job import kinematics_of
    from deltactl.firmware_py.named_files import ROBOT_KEY, find, named_beside
    from deltactl.firmware_py.program.building import make_program
    from deltactl.firmware_py.program.naming import told_with
    from deltactl.firmware_py.robot_file import load_robot
    from deltactl.foundation.counting import count
    from deltactl.foundation.errors import ConfigError
    from deltactl.repair.coverage import coverage

    code, skip = code or [], skip or []
    robot_path = find(robot, key=ROBOT_KEY)
    if job.exists() and not force:
        raise ConfigError(f"{job}: exists already; name another file, or add --force")
    x_mm, y_mm, z_mm = numbers({"origin": origin}, "origin", 3)
    zero = (x_mm / 1e3, y_mm / 1e3, z_mm / 1e3)
    table = source.suffix.lower() in TABLES
    if spline and not table:
        raise ConfigError(f"--spline is for tables of points; the curves of {source} are its own")
    known = load_robot(robot_path)
    if table:
        if code:
            raise ConfigError(f"--code is for G-code, and {source} is a table of points")
        drawn = read_points(source, zero, spline, tuple(skip))
    else:
        drawn = read_gcode(source, zero, meanings_of(skip, code, known.outputs))
    how = (job.stem, named_beside(robot_path, job), speed / 1e3, corner / 1e3)
    made = checked_job(source, drawn, *how)
    for note in filter(None, (*drawn.notes, held(drawn, speed / 1e3))):
        warn(note)
    with (
        written_if_right(job, job_text(drawn, *how), "no job was written"),
        with_an_origin(drawn, robot, zero, speed / 1e3, corner / 1e3),
        told_by_line(source, drawn, made, known),
        told_with(job),
    ):
        program = make_program(made, known, lambda one: kinematics_of(one, known, job))
        show_check(program, job, coverage(made, known, job, robot_path))
    say(f"job: {job}, {count(len(drawn.legs), 'leg')}")
    if said := rounded(drawn, corner):
        say(said)
    say(f"next: deltactl run {job}")
