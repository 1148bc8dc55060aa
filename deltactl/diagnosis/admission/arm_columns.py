"""Columns of a delta's arms that no delta has: step counts that no controller sends, angles that no
arm reaches, and arms in each other's place.
"""

from __future__ import annotations

import itertools

import numpy as np

from deltactl.diagnosis.admission.doubts import usual_largest
from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.admission.refusal import refusal, refuse
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits
from deltactl.foundation.errors import RefusedRecording
from deltactl.models.robot import ARMS, DeltaRobot, RobotModel
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.foreign.doubts import turns
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.tables.flat import FlatRecording

ANGLES = tuple(f"{stem}_{arm}" for stem in ("command", "theta") for arm in (1, 2, 3))
TURN_RAD = 2.0 * np.pi


def check_steps(
    robot: RobotModel, recording: FlatRecording, limits: MotionLimits | None = None
) -> None:
    """Refuse such counts; without `limits` in the robot file an arm may turn half round to either
    side. Raises RefusedRecording, with the column's name and the first row.
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
            raise _at(recording, name, broken, "broken_steps")
        if not isinstance(robot, DeltaRobot) or robot.drive is None:
            continue
        if isinstance(robot.drive, ServoDrive) or recording.motors("steps") is None:
            continue  # counts of fewer motors are of another machine, and refused as that
        angle_deg = np.rad2deg(known * robot.drive.rad_per_step)
        low, high = arm_deg[0] - ADMISSION.beyond_deg, arm_deg[1] + ADMISSION.beyond_deg
        seen = ~np.isnan(counts)
        if len(broken := np.flatnonzero(seen & ((angle_deg < low) | (angle_deg > high)))):
            low, high = arm_deg
            at = {"angle": angle_deg[broken[0]], "low": low, "high": high}
            raise _at(recording, name, broken, "steps_beyond", **at)


def _at(
    recording: FlatRecording, name: str, rows: IntArray, case: str, **values: object
) -> RefusedRecording:
    first = int(rows[0])
    t_s, value = float(recording.t_s[first]), recording.columns[name][first]
    return refusal(case, recording.source, name, first, t_s, value=value, **values).error()


def check_arm_angles(robot: RobotModel, recording: FlatRecording) -> None:
    """Refuse arm angles that are no radians: no arm of a delta turns round.

    Whatever zero its encoder has, an angle of an arm stays within one turn. Raises
    RefusedRecording.
    """
    if not isinstance(robot, DeltaRobot):
        return
    far = {name: usual_largest(recording, name) for name in ANGLES if name in recording.columns}
    name = max(far, key=lambda one: far[one], default=None)
    if name is None or far[name] <= TURN_RAD:
        return
    like = "degrees" if far[name] < np.rad2deg(TURN_RAD) else "counts"
    stems = " and ".join(dict.fromkeys(f"{one[:-2]}_1 to {one[:-2]}_3" for one in far))
    refuse(
        "turning_arm", recording.source, name, far=far[name], turns=turns(far[name]), like=like,
        stems=stems, count_rad=GUESSES.count_rad,
    )  # fmt: skip


def refuse_exchanged_arms(robot: RobotModel, recording: FlatRecording) -> None:
    """Refuse a delta's table in which angles fit other commands than their own far better.

    A wrong home angle does not count; arms that move alike are not distinguished. Raises
    RefusedRecording.
    """
    columns = recording.columns
    names = [[f"{stem}_{arm + 1}" for arm in range(ARMS)] for stem in ("command", "theta")]
    if not isinstance(robot, DeltaRobot) or not all(
        name in columns for group in names for name in group
    ):
        return
    asked, seen = (np.stack([columns[name] for name in group], axis=1) for group in names)
    known = np.isfinite(asked).all(axis=1) & np.isfinite(seen).all(axis=1)
    if not known.any():
        return
    left = {
        order: _apart(seen[known][:, order] - asked[known])
        for order in itertools.permutations(range(ARMS))
    }
    best, *_ = sorted(left, key=lambda order: left[order])
    own = left[tuple(range(ARMS))]
    if not left[best] < ADMISSION.exchanged * own:
        return
    pairs = [(seen + 1, arm + 1) for arm, seen in enumerate(best) if seen != arm]
    follows = " and ".join(f"theta_{seen} follows command_{arm}" for seen, arm in pairs)
    off = {"own": np.degrees(own), "best": np.degrees(left[best])}
    refuse("exchanged_arms", recording.source, f"theta_{pairs[0][0]}", follows=follows, **off)


def _apart(mismatch: FloatArray) -> float:
    """Root mean square of (n, 3) about each column's median [rad]."""
    return float(np.sqrt(np.mean((mismatch - np.median(mismatch, axis=0)) ** 2)))
