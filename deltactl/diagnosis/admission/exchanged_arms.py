"""Arm angles that follow the commands of other arms: columns or motors that were exchanged."""

from __future__ import annotations

import itertools

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.foundation.errors import RecordingError
from deltactl.models.robot import ARMS, DeltaRobot, RobotModel
from deltactl.recording.tables.flat import FlatRecording


def refuse_exchanged_arms(robot: RobotModel, recording: FlatRecording) -> None:
    """Refuse a delta's table in which angles fit other commands than their own far better.

    A wrong home angle does not count; arms that move alike cannot be told. Raises RecordingError.
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
    raise RecordingError(
        f"{recording.source}: {follows}: by their own commands the angles are off by"
        f" {np.degrees(own):.3g} degrees, by these by {np.degrees(left[best]):.3g}. Exchange the"
        " columns (--set theta_1=COLUMN[unit] and so on); where the columns are right, the motors"
        " or encoders of these arms are connected crosswise"
    )


def _apart(mismatch: FloatArray) -> float:
    """Root mean square of (n, 3) about each column's median [rad]."""
    return float(np.sqrt(np.mean((mismatch - np.median(mismatch, axis=0)) ** 2)))
