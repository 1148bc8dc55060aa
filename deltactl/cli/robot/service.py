"""Commands that talk to the daemon, run it or install it, and the service that checks its runs."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.robot.jobs import AcceptOption, JsonOption, SocketOption

POWER = """Energise or release the drives.

```
deltactl power on
```
"""
ABOUT = """Install the service on a Raspberry Pi, and what it runs.

```
deltactl service install
deltactl service daemon zhao-2023.yaml --simulate
```
"""


def _simple(name: str, text: str, group: str = "") -> Callable[..., None]:
    """A command that is one request without arguments."""

    def command(socket: SocketOption = None) -> None:
        from deltactl.cli.robot.remote import do

        do(name, socket)

    command.__name__ = name
    command.__doc__ = f"{text}\n\n```\ndeltactl {group}{name}\n```"
    return command


OF_POWER = (
    _simple("on", "Start the sensors and energise the drives.", "power "),
    _simple("off", "Release the drives. The arms may drop: hold them.", "power "),
)
OF_JOBS = (
    _simple("pause", "Decelerate on the path and hold.", "job "),
    _simple("resume", "Go on from where the job was paused.", "job "),
    _simple(
        "cancel", "Decelerate on the path, drop the job, what is planned and the queue.", "job "
    ),
)
acknowledge = _simple(
    "acknowledge", "Accept an emergency stop or fault whose cause is gone; home afterwards."
)


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
    ctx: typer.Context,
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Keep showing it.")] = False,
    json_out: JsonOption = False,
    socket: SocketOption = None,
) -> None:
    """State, position, job, sensors.

    ```
    deltactl status --json
    deltactl status sensors --watch    the readings alone
    ```
    """
    if ctx.invoked_subcommand is not None:
        return
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
    """Live readings of the three distance sensors.

    ```
    deltactl status sensors
    deltactl status sensors --watch
    deltactl status sensors --calibrate z=0.412
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
    deltactl service daemon zhao-2023.yaml --simulate
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


def install(
    robot: Annotated[
        str | None,
        typer.Option(help="Robot file whose pins are wired; without it, the one in this folder."),
    ] = None,
    apply: Annotated[
        bool, typer.Option("--apply", help="Apply the changes; without this, only show them.")
    ] = False,
) -> None:
    """Install the service on a Raspberry Pi: unit, udev rules, boot options, wiring table.

    ```
    deltactl service install
    sudo .venv/bin/deltactl service install --apply
    ```
    """
    from deltactl.cli.file_arguments import robot_or_here
    from deltactl.firmware_py.install.install import install
    from deltactl.firmware_py.named_files import find

    install(find(robot_or_here(robot)), apply=apply)


def show_version(json_out: bool) -> None:
    """Print the versions of deltactl, Python and the network runtime."""
    import platform

    import numpy

    from deltactl.cli.output import console, facts, print_json
    from deltactl.foundation.release import own_version
    from deltactl.models.network.inverse import runtime_names

    versions = {
        "deltactl": own_version(),
        "python": platform.python_version(),
        "numpy": numpy.__version__,
        "network runtime": runtime_names()[0],
        "machine": platform.machine(),
    }
    if json_out:
        print_json(versions)
    else:
        console.print(facts("deltactl", list(versions.items())))


def check_runs(
    recordings: Annotated[Path, typer.Option(help="The daemon's folder of recordings.")] = Path(
        "recordings"
    ),
    once: Annotated[
        bool, typer.Option("--once", help="Check the existing recordings and exit.")
    ] = False,
    json_out: JsonOption = False,
) -> None:
    """Check every run when it is over, at low priority, and announce a finding that is new.

    The page and `deltactl status` show what is announced.

    ```
    deltactl service check-runs --recordings /var/lib/deltactl/recordings
    deltactl service check-runs --once
    ```
    """
    from rich.markup import escape

    from deltactl.cli.output import print_json, print_wrapped, screen_width
    from deltactl.foundation.extras import needs

    with needs("diagnosis", "service check-runs"):
        import deltactl.diagnosis.api  # noqa: F401
        from deltactl.fleet.checks import RunChecks, outcome, shown
        from deltactl.foundation.one_screen import LINES, laid_out
    os.nice(15)
    checks = RunChecks(recordings)
    rows = []
    try:
        while True:
            rows = checks.look()
            for row in rows if not (json_out or once) else ():
                print_wrapped([escape(f"{Path(row['recording']).name}: {outcome(row)}")])
            if once:
                break
            time.sleep(5.0)
    except KeyboardInterrupt:
        pass
    finally:
        found = checks.announced()
        checks.close()
    if json_out:
        print_json([asdict(mismatch) for mismatch in found])
        return
    parts = shown(rows if once else [], found)
    print_wrapped(map(escape, laid_out(parts, screen_width(), LINES)))
