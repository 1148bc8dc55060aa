"""Whether a table is one of the machine that a robot file describes, and how it is read for it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.firmware_py.named_files import find
from deltactl.foundation.errors import ConfigError, MissingFile
from deltactl.models.robot import ChainRobot, RobotModel, ServoAxis
from deltactl.models.robot_files import load_with_effects

if TYPE_CHECKING:
    from deltactl.recording.foreign.found import Inspection
    from deltactl.recording.foreign.mapping import Mapping


def described(robot: str | None) -> RobotModel | None:
    """The machine of a robot file; None without one, and where its file is still to be written.

    Raises ConfigError for a file that describes none.
    """
    if robot is None:
        return None
    try:
        file = find(robot)
    except MissingFile:
        return None
    return load_with_effects(file) if file.exists() else None


def looked_at(
    path: Path, known: Mapping | None, robot: RobotModel | None
) -> tuple[Inspection, str]:
    """What a table is to a machine, and why it is none of that machine's, empty where it is one.

    Raises RecordingError for a table that cannot be read.
    """
    from deltactl.recording.foreign.arms import as_arm
    from deltactl.recording.foreign.inspection import inspect

    seen = inspect(path, known, robot.motion if isinstance(robot, ServoAxis) else None)
    one_axis = known is not None and not known.columns.keys() <= {"t"}
    arm = None if one_axis or seen.own_run else as_arm(seen)
    if robot is None and arm is not None:
        return arm, ""
    if robot is None or seen.own_run or (seen.kind is None and arm is None):
        return seen, ""
    if isinstance(robot, ChainRobot) and (whole := _of_a_chain(seen, arm, robot)) is not None:
        return whole
    if why := _of_another(seen, robot):
        return seen, why
    if isinstance(robot, ServoAxis) and robot.inertia is None:
        return seen.without_effort, ""
    return seen, ""


def _of_a_chain(
    seen: Inspection, arm: Inspection | None, robot: ChainRobot
) -> tuple[Inspection, str] | None:
    """The table as that of a chain, and why it is none of this one; None where it is none of any.

    arm: the table as that of all joints of an arm.
    """
    from deltactl.recording.foreign.arms import as_chain, fitted_to

    if (whole := as_chain(seen, robot.joints)) is not None:
        return whole, ""
    return None if arm is None else fitted_to(arm, robot.joints, robot.rad_per_count)


def of_its_own(
    path: Path, known: Mapping | None, together: Sequence[Path]
) -> tuple[Inspection, str, str | None]:
    """What a table is to the machine of the robot file that is named after it, or else after one
    of those it is inspected with; why it is none of it, and that file, None where none is there.

    Raises RecordingError for a table that cannot be read.
    """
    from deltactl.recording.foreign.found import robot_named_after

    names = dict.fromkeys(f"{robot_named_after(one)}.yaml" for one in (path, *together))
    own, whole = f"{robot_named_after(path)}.yaml", looked_at(path, known, None)[0]
    if whole.own_run or whole.kind is None:
        return whole, "", None
    reasons: dict[str, str] = {}
    for name in filter(lambda one: Path(one).exists(), names):
        try:
            machine = described(name)
        except ConfigError:
            reasons[name] = "it describes no machine"
            continue
        seen, why = looked_at(path, known, machine)
        if machine and whole.kind == "chain" != machine.kind:
            why = _of_another(whole, machine)
        reasons[name] = why or _of_another_zero(seen, machine)
        if not reasons[name]:
            return seen, "", name
    return (whole, reasons[own], own) if own in reasons else (whole, "", None)


def _of_another_zero(seen: Inspection, robot: RobotModel | None) -> str:
    """Why readings are none of a machine whose zeros mean something; empty where they may be."""
    apart = seen.zero == "arbitrary" and getattr(robot, "zero", None) == "absolute"
    return "its readings lie far from its commands, and there `zero` is absolute" if apart else ""


def _of_another(seen: Inspection, robot: RobotModel) -> str:
    """Why a table is not one of a machine; empty where it may be."""
    from deltactl.recording.foreign.doubts import other_motion

    if seen.kind != robot.kind and not _steps_followed(seen, robot):
        return (
            f"it looks like a table of a {seen.kind}, and the robot file describes a {robot.kind}"
        )
    if not isinstance(robot, ServoAxis):
        return ""
    if seen.needs_inertia and robot.inertia is None:
        return "it has an effort and no command, and the robot file has no `inertia`"
    units = {one.name: one.unit or "1" for one in seen.guesses.values()}
    return other_motion(units, robot.motion)


def _steps_followed(seen: Inspection, robot: RobotModel) -> bool:
    """Whether it is a command and a reading of an axis that turns, as of one with a stepper."""
    both = {"command", "position"} <= {one.name for one in seen.guesses.values()}
    return robot.kind == "stepper_axis" and seen.motion != "linear" and both
