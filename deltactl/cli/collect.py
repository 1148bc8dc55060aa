"""`deltactl network collect`: a survey as a data set, and the robot file that one belongs to."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from deltactl.cli.output import NO_ROBOT, bar, errors, say, tell, warn
from deltactl.cli.robot.jobs import SocketOption
from deltactl.foundation.errors import ConfigError, MissingFile, ServiceError
from deltactl.foundation.extras import needs

if TYPE_CHECKING:
    from deltactl.firmware_py.controller.contract import JobResult, RobotController
    from deltactl.firmware_py.robot_file import RobotFile
    from deltactl.models.training.dataset import DataSet


ABOUT = """Survey a robot, train its network, judge it, and repeat the papers' experiments.

```
deltactl network train --robot zhao-2023.yaml --out nominal.tflite
```
"""
SHIPPED_AS_BUILT = "zhao-2023"
Show = Callable[[int], None]
Sleep = Callable[[float], None]
Machine = Literal["simulated", "robot"]
Survey = Callable[[Machine, "RobotController", Sleep], None]


def collect(
    out: Annotated[Path, typer.Option(help="Folder of the data set; continued if unfinished.")],
    samples: Annotated[int, typer.Option(min=1, help="Number of samples.")] = 5000,
    robot: Annotated[
        str | None, typer.Option(help="Robot file; without it, the one in this folder.")
    ] = None,
    as_built: Annotated[
        str | None,
        typer.Option(
            help="How a MuJoCo robot was built (a file, or zhao-2023): survey that one instead."
        ),
    ] = None,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="On the simulated chain in this process, no daemon.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Draws the poses; any number.")] = 1,
    socket: SocketOption = None,
) -> None:
    """Survey a robot: random arm angles, and where its sensors see it there.

    ```
    deltactl network collect --samples 300 --simulate --out data
    deltactl network collect --samples 5000 --as-built zhao-2023 --out data
    ```
    """
    from deltactl.cli.file_arguments import robot_or_here
    from deltactl.firmware_py.named_files import EXAMPLE, find
    from deltactl.firmware_py.robot_file import load_robot
    from deltactl.models.training.dataset import load_dataset

    path = find(EXAMPLE if robot is None and as_built == SHIPPED_AS_BUILT else robot_or_here(robot))
    described = load_robot(path)
    with bar(total=samples) as draw:

        def show(done: int) -> None:
            draw(done, samples, "")

        if as_built is not None:
            jammed = _as_built(as_built, described, out, samples, seed, show)
        else:
            jammed = 0

            def survey(machine: Machine, controller: RobotController, sleep: Sleep) -> None:
                from deltactl.firmware_py.collecting.by_jobs import collect as run
                from deltactl.firmware_py.collecting.survey import settings_of

                settings = settings_of(described, machine, seed)
                run(out, described, path, settings, samples, _runner(controller, sleep), show)

            _by_jobs(path, out, simulate, socket, survey)
    if jammed:
        warn(f"{jammed} poses were left out: the robot as it was built jams there")
    say(f"{out}: {len(load_dataset(out))} samples")


def _as_built(name: str, robot: RobotFile, out: Path, samples: int, seed: int, show: Show) -> int:
    with needs("proof", "--as-built"):
        from deltactl.reproduction.zhao_2023.as_built import AS_BUILT_FILE, load_as_built
        from deltactl.reproduction.zhao_2023.collecting import collect as run
    file = AS_BUILT_FILE if name == SHIPPED_AS_BUILT else Path(name)
    return run(out, robot, load_as_built(file, robot), samples, seed, show)


def _by_jobs(path: Path, out: Path, simulate: bool, socket: Path | None, survey: Survey) -> None:
    from deltactl.cli.robot.remote import interrupted_between_sleeps
    from deltactl.firmware_py.controller.build import build_controller
    from deltactl.firmware_py.daemon.client import Client, daemon_answers
    from deltactl.firmware_py.machine import is_raspberry_pi

    if not simulate and daemon_answers(socket):
        with Client(socket) as client:
            survey("simulated" if client.status().simulated else "robot", client, time.sleep)
        return
    if not simulate and (socket is not None or is_raspberry_pi()):
        raise ServiceError(
            "no daemon answers; start it with 'sudo systemctl start deltactl',"
            " or use --simulate or --as-built"
        )
    if not simulate:
        tell(NO_ROBOT.format("surveying"), errors)
    controller = build_controller(path, simulated=True, realtime=False, recordings=out)
    try:
        with interrupted_between_sleeps(controller.clock) as sleep:
            controller.power_on()
            controller.home()
            survey("simulated", controller, sleep)
    finally:
        controller.close()


def _runner(controller: RobotController, sleep: Sleep) -> Callable[[Path], JobResult]:
    from deltactl.cli.robot.remote import follow

    def run(job: Path) -> JobResult:
        number = controller.submit(job.resolve())
        return follow(controller, number, sleep, 0.5, quiet=True)

    return run


def robot_file_of(data: DataSet, named: str | None) -> Path:
    """The named robot file, or the one called like the data set's robot.

    Raises MissingFile, or ConfigError where nothing was named and no file is called so.
    """
    from deltactl.firmware_py.named_files import find

    if named is not None:
        return find(named)
    name = data.settings.robot
    try:
        return find(f"{name}.yaml")
    except MissingFile:
        raise ConfigError(
            f"{data.folder}: was taken with robot '{name}', and there is no {name}.yaml here or "
            "in config; name that robot's file with --robot"
        ) from None
