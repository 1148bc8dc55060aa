"""Commands that talk to the daemon: on, off, home, stop, pause, resume, status, sensors, daemon."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.robot.jobs import AcceptOption, JsonOption, SocketOption

SIMPLE: dict[str, str] = {
    "on": "Start the sensors and energise the drives.",
    "off": "Release the drives. The arms may drop: hold them.",
    "pause": "Decelerate on the path and hold.",
    "resume": "Go on from where the job was paused.",
    "cancel": "Decelerate on the path, drop the job, what is planned and the queue.",
    "acknowledge": "Accept an emergency stop or fault whose cause is gone; home afterwards.",
}


def register(app: typer.Typer) -> None:
    """Add the commands of this file."""
    for name, text in SIMPLE.items():
        app.command(name, help=f"{text}\n\n```\ndeltactl {name}\n```")(_simple(name))
    app.command()(home)
    app.command()(stop)
    app.command()(status)
    app.command()(sensors)
    app.command()(daemon)


def _simple(name: str):  # type: ignore[no-untyped-def]
    def command(socket: SocketOption = None) -> None:
        from deltactl.cli.robot.remote import do

        do(name, socket)

    return command


def home(
    accept_unseen: AcceptOption = 0.0,
    robot: Annotated[
        str | None,
        typer.Option(
            help="Another robot file of this machine (a corrected one), in force from now on until"
            " the daemon ends."
        ),
    ] = None,
    socket: SocketOption = None,
) -> None:
    """Learn where the arms are: put them against their stops first.

    ```
    deltactl home
    deltactl home --robot mine.yaml
    deltactl home --accept-unseen 40
    ```
    """
    from deltactl.cli.robot.remote import home_robot
    from deltactl.firmware_py.named_files import find

    home_robot(accept_unseen, None if robot is None else find(robot), socket)


def stop(
    reason: Annotated[str, typer.Option(help="Noted in the recording.")] = "deltactl stop",
    socket: SocketOption = None,
) -> None:
    """Emergency stop: pulses end at once, and the position is no longer trusted.

    ```
    deltactl stop
    ```
    """
    from deltactl.cli.robot.remote import stop_robot

    stop_robot(reason, socket)


def status(
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Keep showing it.")] = False,
    json_out: JsonOption = False,
    socket: SocketOption = None,
) -> None:
    """State, position, job, sensors.

    ```
    deltactl status --json
    ```
    """
    from deltactl.cli.robot.remote import show_status

    show_status(watch, json_out, socket)


def sensors(
    robot: Annotated[
        str | None,
        typer.Option(
            help="Robot file, to read sensors without a daemon; else the one in this folder."
        ),
    ] = None,
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Keep showing them.")] = False,
    calibrate: Annotated[
        str | None,
        typer.Option(help="Axis and true distance, as z=0.412; prints the offset to enter."),
    ] = None,
    json_out: JsonOption = False,
    socket: SocketOption = None,
) -> None:
    """Live readings of the three ranging sensors.

    ```
    deltactl sensors
    deltactl sensors --watch
    deltactl sensors --calibrate z=0.412
    ```
    """
    from deltactl.cli.robot.sensors import show_sensors

    show_sensors(robot, watch, calibrate, json_out, socket)


def daemon(
    robot: Annotated[str, typer.Argument(help="Robot file; sought here, then in config/.")],
    simulate: Annotated[bool, typer.Option("--simulate", help="Run the simulated robot.")] = False,
    recordings: Annotated[Path, typer.Option(help="Folder for recordings.")] = Path("recordings"),
    as_built: Annotated[
        Path | None,
        typer.Option(help="What the simulated robot is really like; goes into no recording."),
    ] = None,
    socket: SocketOption = None,
) -> None:
    """Run the daemon that owns the robot (systemd starts it so).

    `--as-built` names a file with `effects: [...]`, as under `as_built` of a robot file; it is
    read whenever the robot is homed, and may come, change and go while the daemon runs.

    ```
    deltactl daemon zhao-2023.yaml --simulate
    ```
    """
    from deltactl.cli.output import errors
    from deltactl.firmware_py.daemon.main import serve
    from deltactl.firmware_py.machine import is_raspberry_pi
    from deltactl.firmware_py.named_files import find
    from deltactl.foundation.errors import ConfigError

    if not simulate and not is_raspberry_pi():
        simulate = True
        errors.print("This is not a Raspberry Pi: the daemon runs the simulated robot.")
    if as_built is not None and not simulate:
        raise ConfigError("--as-built: of a simulated robot; add --simulate, or leave it out")
    raise typer.Exit(serve(find(robot), socket, simulate, recordings, as_built))
