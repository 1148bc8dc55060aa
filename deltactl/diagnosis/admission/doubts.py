"""What makes an answer doubtful without ending it: values that are probably in another unit, and
columns that this robot file leaves without use.
"""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import Doubt
from deltactl.diagnosis.plants.chain.pose_readings import measures_poses
from deltactl.models.robot import ChainRobot, RangeSensor, RobotModel, ServoAxis, StepperAxis
from deltactl.recording.column_measures import first_of
from deltactl.recording.foreign.doubts import TURNS_RAD, of_encoder, turns
from deltactl.recording.tables.chain_tables import targets_in
from deltactl.recording.tables.flat import FlatRecording


def doubts_of(robot: RobotModel, recording: FlatRecording) -> Doubt | None:
    """The first doubt about its units, if there is any."""
    return (
        steps_of_degrees(robot, recording)
        or far_for_a_joint(robot, recording)
        or far_for_a_sensor(robot, recording)
        or places_beside_efforts(robot, recording)
    )


def places_beside_efforts(robot: RobotModel, recording: FlatRecording) -> Doubt | None:
    """That the places of a chain in motion, whose efforts are used, are not."""
    if not isinstance(robot, ChainRobot) or measures_poses(robot, recording):
        return None
    for target in targets_in(recording):
        return Doubt(
            recording.source,
            f"{target}_x",
            f"the places {target}_x..z in {recording.source} are not used, as its efforts are: "
            "for lengths and zeros, diagnose a table of the same without its effort columns.",
        )
    return None


def steps_of_degrees(robot: RobotModel, recording: FlatRecording) -> Doubt | None:
    """That an axis that turns reads in an encoder's steps of degrees, not of rad."""
    for name in ("position", "theta_1") if _turns(robot) else ():
        unit, step = of_encoder(recording.columns.get(name, np.zeros(0))) or ("", "")
        if unit == "deg":
            return Doubt(
                recording.source,
                name,
                f"{name} of {recording.source} was read in rad, and its readings go {step}: "
                "it is probably in degrees, and every size below then 57 times too large: give the"
                f' unit of it and of the command, as --set "{name}=COLUMN[deg]".',
            )
    return None


def _turns(robot: RobotModel) -> bool:
    """Whether it is one axis that turns."""
    return isinstance(robot, StepperAxis) or (
        isinstance(robot, ServoAxis) and robot.motion == "rotary"
    )


def far_for_a_joint(robot: RobotModel, recording: FlatRecording) -> Doubt | None:
    """That a turning axis goes through more turns than joints do; motors may."""
    for name in ("position", "theta_1", "command", "command_1"):
        values = recording.columns.get(name)
        if not _turns(robot) or values is None or not np.isfinite(values).any():
            continue
        if name in recording.units_given:
            return None
        farthest = usual_largest(recording, name)
        if farthest <= TURNS_RAD:
            return None
        return Doubt(
            recording.source,
            name,
            f"{name} of {recording.source} goes up to {farthest:.4g} rad, which are"
            f" {turns(farthest)}. A motor may turn so far; where no joint of this machine does,"
            f" {name} is in another unit than it was read in (degrees, seconds of arc or"
            " counts, say), and every size below is wrong: give its own, as"
            f' --set "{name}=COLUMN[UNIT]", or what one is in rad, as "{name}=COLUMN*FACTOR".',
        )
    return None


def usual_largest(recording: FlatRecording, name: str) -> float:
    """What nearly all readings of a column stay below [rad]; 0 for an empty one."""
    known = np.abs(recording.columns[name])
    known = known[np.isfinite(known)]
    return float(np.quantile(known, ADMISSION.most_of_arms)) if len(known) else 0.0


def far_for_a_sensor(robot: RobotModel, recording: FlatRecording) -> Doubt | None:
    """That most distances are farther than distance sensors see."""
    if not isinstance(robot, RangeSensor) or "distance" not in recording.columns:
        return None
    known = recording.columns["distance"]
    known = known[np.isfinite(known)]
    if not len(known) or float(np.median(np.abs(known))) <= ADMISSION.farthest_ranged_m:
        return None
    return Doubt(
        recording.source,
        "distance",
        f"distance of {recording.source} goes up to {float(np.max(np.abs(known))):,.0f} m, and few"
        " sensors see so far. If it is in mm, every size below is 1000 times too large: give the"
        ' unit of both columns, as --set "distance=COLUMN[mm]" --set "range=COLUMN[mm]".',
    )


def effort_unused(robot: RobotModel, recording: FlatRecording, column: str | None) -> str:
    """Why the effort beside a command is not used, and what it may be instead; empty where it is
    used, or there is none. column: its name in the file, where it has another one.
    """
    if not isinstance(robot, ServoAxis) or robot.inertia is not None:
        return ""
    if first_of(recording, ["effort"]) is None or first_of(recording, ["command"]) is None:
        return ""
    return (
        "effort is not used, as the robot file has no `inertia`: what the drive gives says nothing"
        " without it. If it pulls at the axis from outside (a weight, a spring), read it as load:"
        f" --set load={column or 'effort'}"
    )


def command_unused(recording: FlatRecording, columns: tuple[str | None, str | None]) -> str:
    """That the command beside an effort is not used, of a diagnosis of forces, and how to get the
    other one; empty where there is none. columns: names of command and effort in the file.
    """
    if first_of(recording, ["command"]) is None:
        return ""
    command, effort = columns
    told = f" ({command})" if command else ""
    leave_out = f"--set effort={effort}" if effort else "the column `effort`"
    return (
        f"the command{told} is not used: with `inertia` in the robot file and an effort, forces are"
        " compared (friction, mass). To compare the position with its command instead (delay,"
        f" play, backlash), leave out {leave_out}"
    )
