"""Commands for single moves and places: goto, jog, teach, convert."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from deltactl.cli.help_screens import MORE
from deltactl.cli.robot.jobs import AcceptOption, JsonOption, SocketOption
from deltactl.firmware_py.importing.drawn import CORNER_MM
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.printable import plain

Place = tuple[float, float, float]


class Move(NamedTuple):
    """A single move, as it was typed."""

    name: str
    place_m: Place
    speed_mmps: float


WHAT = {"stopped": "stop", "fault": "fault"}
RobotOption = Annotated[
    str | None, typer.Option(help="Robot file; without it the one that the daemon runs.")
]
SimulateOption = Annotated[
    bool, typer.Option("--simulate", help="On a simulated robot in this process, no daemon.")
]
SpeedOption = Annotated[float, typer.Option("--speed", min=0.001, help="Greatest speed, mm/s.")]


def goto(
    x: Annotated[float, typer.Argument(help="mm, from the middle of the base towards motor 1.")],
    y: Annotated[float, typer.Argument(help="mm, to the left of x as seen from above.")],
    z: Annotated[
        float, typer.Argument(help="mm, up; 0 at the motor axes, so below them it is negative.")
    ],
    speed: SpeedOption = 50.0,
    robot: RobotOption = None,
    simulate: SimulateOption = False,
    accept_unseen: AcceptOption = 0.0,
    json_out: JsonOption = False,
    socket: SocketOption = None,
) -> None:
    """Move the platform straight to a position. Checked before anything moves, along the whole way.

    Positions are those of the middle of the platform, at the height of its joints.

    ```
    deltactl goto 20 0 -450
    deltactl goto 20 0 -450 --robot zhao-2023.yaml --simulate
    ```
    """
    place_m = (x / 1e3, y / 1e3, z / 1e3)
    _go(Move("goto", place_m, speed), robot, simulate, json_out, socket, accept_unseen)


def jog(
    x: Annotated[float, typer.Option(help="By so many mm.")] = 0.0,
    y: Annotated[float, typer.Option(help="By so many mm.")] = 0.0,
    z: Annotated[float, typer.Option(help="By so many mm.")] = 0.0,
    speed: SpeedOption = 20.0,
    robot: RobotOption = None,
    json_out: JsonOption = False,
    socket: SocketOption = None,
) -> None:
    """Move the platform by a little from where it is, in a straight line.

    ```
    deltactl jog --z -5
    deltactl jog --x 1 --y 1 --speed 5
    ```
    """
    from deltactl.foundation.errors import ConfigError

    if not (x or y or z):
        raise ConfigError("say how far: --x, --y or --z, in mm")
    here = platform_m(socket)
    there = (here[0] + x / 1e3, here[1] + y / 1e3, here[2] + z / 1e3)
    _go(Move("jog", there, speed), robot, False, json_out, socket)


def _go(
    move: Move,
    robot: str | None,
    simulate: bool,
    json_out: bool,
    socket: Path | None,
    accept_unseen_deg: float = 0.0,
) -> None:
    """Through the daemon where one answers, else on the simulated robot of a file."""
    from deltactl.cli.robot.run import refuse_unseen
    from deltactl.firmware_py.daemon.client import daemon_answers
    from deltactl.foundation.errors import ConfigError

    if not simulate and daemon_answers(socket):
        if robot is not None:
            raise ConfigError(
                f"--robot {robot}: the daemon runs the robot file it was started with; leave it"
                " out, or add --simulate"
            )
        refuse_unseen(accept_unseen_deg)
        with _told_as_typed(move):
            _go_through_daemon(move, json_out, socket)
        return
    if robot is None:
        from deltactl.firmware_py.named_files import robots_here

        say = " or ".join(f"--robot {name}" for name in robots_here() or ["FILE"])
        raise ConfigError(f"no daemon answers that could say which robot this is; add {say}")
    with _told_as_typed(move):
        _go_simulated(move, robot, simulate, json_out, socket)


@contextmanager
def _told_as_typed(move: Move) -> Iterator[None]:
    """What breaks a limit, with the place in mm as it was typed, and no point of a job."""
    from deltactl.foundation.errors import ELSEWHERE, MotionError

    try:
        yield
    except MotionError as error:
        if (wrong := error.at_point) is None:
            raise
        way = "on the way to " if wrong.on_the_way else ""
        where = " ".join(plain(1e3 * value) for value in move.place_m)
        if wrong.remedy == ELSEWHERE:
            wrong = replace(wrong, remedy="choose another place")
        raise error.worded(f"{move.name}: {way}{where} mm: {wrong.says()}") from error


def _text(move: Move, robot: str) -> str:
    import json

    x_m, y_m, z_m = move.place_m
    return (
        f"name: {move.name}\nrobot: {json.dumps(robot)}\n"
        f"path: {{shape: straight, to_m: [{x_m:.9g}, {y_m:.9g}, {z_m:.9g}]}}\n"
        f"timing: {{mode: accelerated, speed_mps: {move.speed_mmps / 1e3:.9g}}}\n"
        "inverse_kinematics: {kind: geometry}\n"
    )


def _go_simulated(
    move: Move, robot: str, simulate: bool, json_out: bool, socket: Path | None
) -> None:
    from tempfile import TemporaryDirectory

    from deltactl.cli.output import say
    from deltactl.cli.robot.run import Asked, run_job
    from deltactl.firmware_py.named_files import ROBOT_KEY, find
    from deltactl.firmware_py.planner.plan import plan_of
    from deltactl.models.calibrated_inverse import CalibratedInverse
    from deltactl.models.linkage.scalar import counted_pose

    with TemporaryDirectory() as folder:
        job = Path(folder) / f"{move.name}.yaml"
        text = _text(move, str(find(robot, key=ROBOT_KEY).resolve()))
        write_whole(job, text)
        asked = Asked(simulate=simulate, json_out=json_out, socket=socket, one_place=True)
        run_job(job, asked)
        plan = plan_of(job)
    if not json_out:
        position_of = CalibratedInverse(plan.robot).position_of_one_m
        _, reached_m = counted_pose(plan.last_counts, plan.robot.drive.rad_per_step, position_of)
        say(f"the simulated platform is at {_words(reached_m or move.place_m)} mm")


def _go_through_daemon(move: Move, json_out: bool, socket: Path | None) -> None:
    import time
    from dataclasses import asdict

    from deltactl.cli.output import print_json, say, warn
    from deltactl.cli.robot.remote import follow, refuse_unless_done
    from deltactl.cli.robot.run import POLL_S, dropped_when_interrupted
    from deltactl.firmware_py.daemon.client import Client

    with Client(socket) as client:
        robot = client.status().robot_file
        with dropped_when_interrupted():
            number = client.submit_text(_text(move, robot), f"{move.name}.yaml")
        result = follow(client, number, time.sleep, POLL_S, json_out)
        position_m = client.status().position_m
    if json_out:
        print_json(asdict(result) | {"position_m": position_m})
    elif result.outcome == "done" and position_m is not None:
        if result.warning:
            warn(result.warning)
        say(f"the platform is at {_words(position_m)} mm")
    refuse_unless_done(result)


def platform_m(socket: Path | None) -> Place:
    """Where the platform of the daemon's robot is. Raises NotReady while nobody knows."""
    from deltactl.firmware_py.controller.states import State, way_out
    from deltactl.firmware_py.daemon.client import Client
    from deltactl.foundation.errors import NotReady

    with Client(socket) as client:
        status = client.status()
    if status.state in ("planning", "running", "paused"):
        job = status.job or ", ".join((*status.queued, *status.planning))
        raise NotReady(
            f"the robot is {status.state}: {job}; wait for its end, or 'deltactl job cancel'"
        )
    if status.position_m is None:
        what = f" since the {WHAT[status.state]} ({status.why})" if status.state in WHAT else ""
        way = way_out(State(status.state), status.simulated)
        raise NotReady(f"the position is unknown{what}; {way}")
    return status.position_m


def _words(place_m: Place) -> str:
    return " ".join(f"{1e3 * value:z.2f}" for value in place_m)


def teach(
    points: Annotated[Path, typer.Argument(help="Table to add to (.csv); created if missing.")],
    dwell: Annotated[float, typer.Option(min=0.0, help="Wait there, s.")] = 0.0,
    socket: SocketOption = None,
) -> None:
    """Save the platform's position as the next point of a table; `convert` turns it into a job.

    ```
    deltactl job teach pick.csv
    deltactl convert pick.csv pick.yaml --robot zhao-2023.yaml
    ```
    """
    from deltactl.cli.output import say
    from deltactl.firmware_py.importing.point_columns import add_point

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
    block_delete: Annotated[
        bool | None,
        typer.Option(
            help="Leave out lines of G-code that begin with '/', or carry them out; else refused.",
            rich_help_panel=MORE,
        ),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")] = False,
) -> None:
    """Turn G-code or a table of points into a job, and check it.

    ```
    deltactl convert part.gcode part.yaml --robot my.yaml --origin "0 0 -450"
    deltactl convert slice.gcode slice.yaml --robot my.yaml --skip G28
    deltactl convert points.csv path.yaml --robot zhao-2023.yaml --corner 1
    deltactl convert points.csv path.yaml --robot zhao-2023.yaml --spline
    ```
    """
    from deltactl.cli.file_arguments import written_if_right
    from deltactl.cli.output import say, warn
    from deltactl.cli.robot.check import show_check
    from deltactl.firmware_py.describing.questions import numbers
    from deltactl.firmware_py.importing.by_line import checked_job, told_by_line, with_an_origin
    from deltactl.firmware_py.importing.drawn import TABLES, held, job_text, rounded
    from deltactl.firmware_py.importing.gcode import read_gcode
    from deltactl.firmware_py.importing.gcode_tables import meanings_of
    from deltactl.firmware_py.importing.points_table import read_points
    from deltactl.firmware_py.job_targets import kinematics_of
    from deltactl.firmware_py.named_files import ROBOT_KEY, find, named_beside
    from deltactl.firmware_py.program.building import make_program, told_with
    from deltactl.firmware_py.program.coverage import coverage
    from deltactl.firmware_py.robot_file import load_robot
    from deltactl.foundation.errors import ConfigError
    from deltactl.foundation.printable import count

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
        if code or block_delete is not None:
            option = "--code" if code else "--block-delete"
            raise ConfigError(f"{option} is for G-code, and {source} is a table of points")
        drawn = read_points(source, zero, spline, tuple(skip))
    else:
        drawn = read_gcode(source, zero, meanings_of(skip, code, known.outputs, block_delete))
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
        program = make_program(made, known, lambda part: kinematics_of(part, known, job))
        show_check(program, job, coverage(made, known, job, robot_path))
    say(f"job: {job}, {count(len(drawn.legs), 'leg')}")
    if said := rounded(drawn, corner):
        say(said)
    say(f"next: deltactl run {job}")
