"""Step counts that no controller sends: no whole numbers, or beyond where the arms can go."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import DeltaRobot, RobotModel
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.tables.flat import FlatRecording


def check_steps(
    robot: RobotModel, recording: FlatRecording, limits: MotionLimits | None = None
) -> None:
    """Refuse such counts; without `limits` in the robot file an arm may turn half round to either
    side. Raises RecordingError, with the column's name and the first row.
    """
    known_limits = limits is not None and "arm_deg" in limits.model_fields_set
    half = ADMISSION.half_round_deg
    arm_deg = limits.arm_deg if limits is not None and known_limits else (-half, half)
    for motor in (1, 2, 3):
        name = f"steps_{motor}"
        counts = recording.columns.get(name)
        if counts is None:
            continue
        known = np.nan_to_num(counts)
        if len(broken := np.flatnonzero(known != np.rint(known))):
            raise _refused(recording, name, broken, "a count of microsteps is a whole number")
        if not isinstance(robot, DeltaRobot) or robot.drive is None:
            continue
        if isinstance(robot.drive, ServoDrive) or recording.motors("steps") is None:
            continue  # counts of fewer motors are of another machine, and refused as that
        angle_deg = np.rad2deg(known * robot.drive.rad_per_step)
        low, high = arm_deg[0] - ADMISSION.beyond_deg, arm_deg[1] + ADMISSION.beyond_deg
        seen = ~np.isnan(counts)
        if len(broken := np.flatnonzero(seen & ((angle_deg < low) | (angle_deg > high)))):
            raise _refused(
                recording, name, broken,
                f"the arm would stand at {angle_deg[broken[0]]:.4g} deg, and its limits are "
                f"{arm_deg[0]:g} to {arm_deg[1]:g} deg; is the drive of the robot file right?",
            )  # fmt: skip


def _refused(
    recording: FlatRecording, name: str, rows: np.ndarray[tuple[int], np.dtype[np.intp]], why: str
) -> RecordingError:
    first = int(rows[0])
    return RecordingError(
        f"{recording.source}: {name} is {recording.columns[name][first]:.6g} at "
        f"{recording.t_s[first]:g} s: {why}"
    )
