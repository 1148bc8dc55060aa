"""Angles that no joint has: degrees or counts that were read as radians."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import DeltaRobot, RobotModel, ServoAxis, StepperAxis
from deltactl.recording.foreign.doubts import TURNS_RAD, turns
from deltactl.recording.foreign.encoder_steps import of_encoder
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.tables.flat import FlatRecording

ARMS = tuple(f"{stem}_{arm}" for stem in ("command", "theta") for arm in (1, 2, 3))
TURN_RAD = 2.0 * np.pi


def check_arm_angles(robot: RobotModel, recording: FlatRecording) -> None:
    """Refuse arm angles that are no radians: no arm of a delta turns round. Raises RecordingError.

    Whatever zero its encoder has, an angle of an arm stays within one turn.
    """
    if not isinstance(robot, DeltaRobot):
        return
    far = {name: _usual_largest(recording, name) for name in ARMS if name in recording.columns}
    name = max(far, key=lambda one: far[one], default=None)
    if name is None or far[name] <= TURN_RAD:
        return
    like = "degrees" if far[name] < np.rad2deg(TURN_RAD) else "counts"
    stems = " and ".join(dict.fromkeys(f"{one[:-2]}_1 to {one[:-2]}_3" for one in far))
    one = f"{name}=COLUMN*{GUESSES.count_rad}"
    raise RecordingError(
        f"{recording.source}: {name} goes up to {far[name]:.4g} rad ({turns(far[name])}), and no"
        f" arm of a delta turns round: these look like {like}. Give the unit of each of {stems}, as"
        f' --set "{name}=COLUMN[deg]" (of counts what one is in rad: "{one}");'
        f" to see it for your columns, type: deltactl diagnose {recording.source} --inspect"
    )


def _usual_largest(recording: FlatRecording, name: str) -> float:
    """What nearly all readings of a column stay below [rad]; 0 for an empty one."""
    known = np.abs(recording.columns[name])
    known = known[np.isfinite(known)]
    return float(np.quantile(known, ADMISSION.most_of_arms)) if len(known) else 0.0


def steps_of_degrees(robot: RobotModel, recording: FlatRecording) -> list[str]:
    """A sentence where an axis that turns reads in an encoder's steps of degrees, not of rad."""
    for name in ("position", "theta_1") if _turns(robot) else ():
        unit, step = of_encoder(recording.columns.get(name, np.zeros(0))) or ("", "")
        if unit == "deg":
            return [
                f"{name} of {recording.source} was read in rad, and its readings stand {step}: it"
                " is probably in degrees, and every size below then 57 times too large: give the"
                f' unit of it and of the command, as --set "{name}=COLUMN[deg]".'
            ]
    return []


def _turns(robot: RobotModel) -> bool:
    """Whether it is one axis that turns."""
    return isinstance(robot, StepperAxis) or (
        isinstance(robot, ServoAxis) and robot.motion == "rotary"
    )


def far_for_a_joint(robot: RobotModel, recording: FlatRecording) -> list[str]:
    """A sentence where a turning axis goes through more turns than joints do; motors may."""
    for name in ("position", "theta_1", "command", "command_1"):
        values = recording.columns.get(name)
        if not _turns(robot) or values is None or not np.isfinite(values).any():
            continue
        farthest = _usual_largest(recording, name)
        if farthest > TURNS_RAD:
            return [
                f"{name} of {recording.source} goes up to {farthest:.4g} rad, which are"
                f" {turns(farthest)}. A motor may turn so far; where no joint of this machine does,"
                f" {name} is in another unit than it was read in (degrees, seconds of arc or"
                " counts, say), and every size below is wrong: give its own, as"
                f' --set "{name}=COLUMN[UNIT]", or what one is in rad, as "{name}=COLUMN*FACTOR".'
            ]
        return []
    return []
