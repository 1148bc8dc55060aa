"""`deltactl init chain`: the robot file of an arm or gantry that a URDF or MJCF describes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deltactl.cli.file_arguments import ForceOption, written_if_right
from deltactl.cli.output import say, tell
from deltactl.firmware_py.describing.question import UNKNOWN
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import write_whole

if TYPE_CHECKING:
    from deltactl.models.rigid_chain import RigidChain
    from deltactl.models.robot import RobotModel

FileArgument = Annotated[Path, typer.Argument(help="Robot file to write (.yaml).")]
ModelOption = Annotated[Path, typer.Option(help="URDF (.urdf) or MJCF (.xml) of the robot.")]
JointsOption = Annotated[
    str | None, typer.Option(help="Joints in the order of the columns, as a,b,c (all).")
]
GainOption = Annotated[
    str | None,
    typer.Option(
        help="N m or N at the joint for one unit of effort: one, or one a joint (1); or unknown."
    ),
]
PosesOption = Annotated[
    int | None,
    typer.Option(min=15, max=500, help="Also write so many poses to measure, as *-poses.csv."),
]
MotionOption = Annotated[
    bool, typer.Option(help="Also write a motion that shows most of the efforts, as *-motion.*.")
]


def chain(
    file: FileArgument,
    model: ModelOption,
    joints: JointsOption = None,
    effort_gain: GainOption = None,
    name: Annotated[str | None, typer.Option(help="What reports call it.")] = None,
    poses: PosesOption = None,
    motion: MotionOption = False,
    force: ForceOption = False,
) -> None:
    """Describe joints one behind the other: any robot with a URDF or MJCF.

    ```
    deltactl init chain arm.yaml --model arm.urdf
    deltactl init chain arm.yaml --model arm.urdf --effort-gain 11.9,11.9,9.8
    deltactl init chain arm.yaml --model arm.urdf --poses 60 --motion
    ```
    """
    from deltactl.models.rigid_chain import RigidChain, moving_joints
    from deltactl.models.robot_files import load_with_effects

    measured = file.with_name(f"{file.stem}-poses.csv")
    job = file.with_name(f"{file.stem}-motion.yaml")
    moved = [job, job.with_suffix(".csv")] if motion else []
    for there in (file, *moved, *([measured] if poses is not None else [])):
        if there.exists() and not force:
            raise ConfigError(f"{there}: exists already; name another file, or add --force")
    chosen = joints.split(",") if joints else moving_joints(model)
    described = RigidChain(model, chosen)
    gains = _gains(effort_gain or "1", chosen)
    text = (
        f"kind: chain\nname: {name or file.stem}\n"
        f"model: {Path(os.path.relpath(model, file.parent)).as_posix()}\n"
        f"joints: [{', '.join(chosen)}]  # in the order of the columns theta_1, theta_2, ...\n"
        f"effort_gain: {gains}  # N m (N of a slide) at the joint for one unit of effort\n"
        "gravity: on  # off where the efforts have no weight in them\n"
    )
    with written_if_right(file, text):
        robot = load_with_effects(file)
    if effort_gain is None:
        tell("assumed:         --effort-gain 1 (the efforts are in N m, those of a slide in N)")
    say(f"robot file: {file}")
    if poses is not None:
        _write_poses(measured, robot, described, poses)
    if motion:
        _write_motion(job, robot, described)
    say(f"next: deltactl diagnose RECORDING --robot {file}")


def _write_poses(file: Path, robot: RobotModel, described: RigidChain, count: int) -> None:
    """Poses in which to measure the robot, as commands of its joints."""
    from deltactl.diagnosis.experiment.calibration_poses import calibration_poses
    from deltactl.models.robot import ChainRobot

    assert isinstance(robot, ChainRobot)
    names = [f"command_{number}" for number in range(1, len(robot.joints) + 1)]
    rows = calibration_poses(robot, described, count)
    lines = [",".join(names), *(",".join(f"{x:.5f}" for x in row) for row in rows)]
    write_whole(file, "\n".join([*lines, ""]))
    say(f"poses to measure: {file}; see first that the arm meets nothing on its way")


def _write_motion(job: Path, robot: RobotModel, described: RigidChain) -> None:
    """A motion in which to record the efforts, as a job and as commands of the joints."""
    import yaml

    from deltactl.diagnosis.experiment.exciting_motion import exciting_motion
    from deltactl.models.robot import ChainRobot

    assert isinstance(robot, ChainRobot)
    series = exciting_motion(robot, described)
    write_whole(job, yaml.safe_dump(series.job(robot.name), default_flow_style=None))
    names = [f"command_{number}" for number in range(1, len(robot.joints) + 1)]
    lines = [",".join(["t", *names])]
    lines += [",".join(f"{x:.5f}" for x in row) for row in series.table()]
    write_whole(job.with_suffix(".csv"), "\n".join([*lines, ""]))
    say(f"motion to record: {job} and .csv; see first that the arm meets nothing on its way")


def _gains(text: str, joints: list[str]) -> str:
    """The value of `effort_gain` in the file. Raises ConfigError, which says what to type."""
    if text == UNKNOWN:
        return UNKNOWN
    numbers = text.split(",")
    if len(numbers) not in (1, len(joints)):
        raise ConfigError(
            f"--effort-gain has {len(numbers)} numbers for the joints {', '.join(joints)}: give"
            " one, or one a joint"
        )
    try:
        values = [float(number) for number in numbers]
    except ValueError:
        raise ConfigError(
            f"--effort-gain: '{text}' is no list of numbers, as 11.9,11.9, nor unknown"
        ) from None
    return str(values[0]) if len(values) == 1 else str(values)
