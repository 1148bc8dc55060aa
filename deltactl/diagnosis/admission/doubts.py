"""What makes an answer doubtful without ending it: values that are probably in another unit, and
columns that this robot file leaves without use.
"""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import Doubt, doubt
from deltactl.models.robot import ChainRobot, RangeSensor, RobotModel, ServoAxis, StepperAxis
from deltactl.recording.foreign.doubts import TURNS_RAD, of_encoder, turns
from deltactl.recording.tables.chain_tables import measures_poses, targets_in
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
    if not isinstance(robot, ChainRobot) or measures_poses(robot.joints, recording):
        return None
    for target in targets_in(recording):
        return doubt("places_unused", recording.source, f"{target}_x", target=target)
    return None


def steps_of_degrees(robot: RobotModel, recording: FlatRecording) -> Doubt | None:
    """That an axis that turns reads in an encoder's steps of degrees, not of rad."""
    for name in ("position", "theta_1") if _turns(robot) else ():
        unit, step = of_encoder(recording.columns.get(name, np.zeros(0))) or ("", "")
        if unit == "deg":
            return doubt("steps_of_degrees", recording.source, name, step=step)
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
        far = {"farthest": farthest, "turns": turns(farthest)}
        return doubt("far_for_a_joint", recording.source, name, **far)
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
    farthest = float(np.max(np.abs(known)))
    return doubt("far_for_a_sensor", recording.source, "distance", farthest=farthest)
