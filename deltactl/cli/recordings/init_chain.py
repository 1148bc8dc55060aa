"""`deltactl init chain`: the robot file of an arm or gantry that a URDF or MJCF describes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deltactl.cli.file_arguments import ForceOption, written_if_right
from deltactl.cli.output import say, tell
from deltactl.firmware_py.describing.question import UNKNOWN, Question, read_numbers
from deltactl.firmware_py.describing.questions import GEAR, MICROSTEPS
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import write_whole

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from deltactl.models.rigid_chain import RigidChain
    from deltactl.models.robot import ChainRobot, RobotModel

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
NO_COUNTS = "none"
MicrostepsOption = Annotated[
    str | None,
    typer.Option(
        help="Step pulses, or counts of an encoder, for one turn of the motor, where columns count:"
        f" one, or one a joint; {NO_COUNTS} of a joint in rad."
    ),
]
GearOption = Annotated[
    str | None,
    typer.Option(help="With it, turns of the motor for one of the joint (1): one, or one a joint."),
]
ZeroOption = Annotated[
    str | None,
    typer.Option(help="With it, count at which the joint is at the model's zero (0), as 2048."),
]
PosesOption = Annotated[
    int | None,
    typer.Option(min=15, max=500, help="Also write so many poses to measure, as *-poses.csv."),
]
MotionOption = Annotated[
    bool,
    typer.Option(
        "--motion", help="Also write a motion that shows most of the efforts, as *-motion.*."
    ),
]


def chain(
    file: FileArgument,
    model: ModelOption,
    joints: JointsOption = None,
    effort_gain: GainOption = None,
    microsteps_per_rev: MicrostepsOption = None,
    gear_ratio: GearOption = None,
    zero_count: ZeroOption = None,
    name: Annotated[str | None, typer.Option(help="What reports call it.")] = None,
    poses: PosesOption = None,
    motion: MotionOption = False,
    force: ForceOption = False,
) -> None:
    """Describe joints one behind the other: any robot with a URDF or MJCF.

    ```
    deltactl init chain arm.yaml --model arm.urdf
    deltactl init chain arm.yaml --model arm.urdf --effort-gain 11.9,11.9,9.8
    deltactl init chain arm.yaml --model arm.urdf --microsteps-per-rev 4096
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
        f"{_drives(microsteps_per_rev, gear_ratio, described)}"
        f"{_zeros(zero_count, microsteps_per_rev, chosen)}"
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
    lines = [",".join(names), *(_commanded(robot, row) for row in rows)]
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
    lines += [f"{row[0]:.5f},{_commanded(robot, row[1:])}" for row in series.table()]
    write_whole(job.with_suffix(".csv"), "\n".join([*lines, ""]))
    say(f"motion to record: {job} and .csv; see first that the arm meets nothing on its way")


def _commanded(robot: ChainRobot, positions: Iterable[float]) -> str:
    """Commands of all joints in one row, in the counts of those that have a drive."""
    each = zip(positions, robot.rad_per_count, robot.zero_counts, strict=True)
    return ",".join(f"{x:.5f}" if rad is None else f"{x / rad + zero:.0f}" for x, rad, zero in each)


def _gains(text: str, joints: list[str]) -> str:
    """The value of `effort_gain` in the file. Raises ConfigError, which says what to type."""
    if text == UNKNOWN:
        return UNKNOWN
    numbers = _each("--effort-gain", text, joints)
    try:
        values = [float(number) for number in numbers]
    except ValueError:
        raise ConfigError(
            f"--effort-gain: '{text}' is no list of numbers, as 11.9,11.9, nor unknown"
        ) from None
    return str(values[0]) if len(values) == 1 else str(values)


def _drives(microsteps: str | None, gear: str | None, described: RigidChain) -> str:
    """The line `drive` of the file, empty where all columns are angles. Raises as `_gains`."""
    if microsteps is None:
        if gear is not None:
            raise ConfigError(f"{GEAR.option} is given with {MICROSTEPS.option}")
        return ""
    options = ((MICROSTEPS, microsteps), (GEAR, gear or "1"))
    pairs = zip(*(_numbers(one, text, described) for one, text in options), strict=True)
    made = [
        "null"
        if None in (pulses, turns)
        else f"{{microsteps_per_rev: {pulses:.0f}, gear_ratio: {turns:.10g}}}"
        for pulses, turns in pairs
    ]
    return f"drive: [{', '.join(made)}]  # of joints whose columns count; null: in rad or m\n"


def _zeros(text: str | None, microsteps: str | None, joints: list[str]) -> str:
    """The line `zero_count` of the file, empty where it is 0. Raises as `_gains`."""
    if text is None:
        return ""
    if microsteps is None:
        raise ConfigError(f"--zero-count is given with {MICROSTEPS.option}")
    try:
        counts = [int(number) for number in _each("--zero-count", text, joints)]
    except ValueError:
        raise ConfigError(
            f"--zero-count: '{text}' is no list of whole numbers, as 2048,2048"
        ) from None
    value = counts[0] if len(counts) == 1 else counts
    return f"zero_count: {value}  # at the zero of the model\n"


def _numbers(question: Question, text: str, described: RigidChain) -> list[float | None]:
    """A number of each joint; None of one in rad, and of slides, which no drive turns."""
    said = _each(question.option, text, described.joints)
    for one in said:
        if wrong := question.wrong(one):
            raise ConfigError(f"{question.option} {wrong}")
    each = said * (len(described.joints) // len(said))
    found = [read_numbers(one, 1, question.notation) for one in each]
    pairs = zip(found, described.slides, strict=True)
    return [None if slides or isinstance(one, str) else one[0] for one, slides in pairs]


def _each(option: str, text: str, joints: Sequence[str]) -> list[str]:
    """What an option says of all joints, or of each. Raises ConfigError for another number."""
    said = text.split(",")
    if len(said) not in (1, len(joints)):
        raise ConfigError(
            f"{option} has {len(said)} numbers for the joints {', '.join(joints)}: give one, or one"
            " a joint"
        )
    return said
