"""Distances that no ranging sensor measures: another unit that was read as metres."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.admission.options import ADMISSION
from deltactl.models.robot import RangeSensor, RobotModel
from deltactl.recording.tables.flat import FlatRecording


def far_for_a_sensor(robot: RobotModel, recording: FlatRecording) -> list[str]:
    """A sentence where most distances are farther than ranging sensors see."""
    if not isinstance(robot, RangeSensor) or "distance" not in recording.columns:
        return []
    known = recording.columns["distance"]
    known = known[np.isfinite(known)]
    if not len(known) or float(np.median(np.abs(known))) <= ADMISSION.farthest_ranged_m:
        return []
    return [
        f"distance of {recording.source} goes up to {float(np.max(np.abs(known))):,.0f} m, and few"
        " sensors see so far. If it is in mm, every size below is 1000 times too large: give the"
        ' unit of both columns, as --set "distance=COLUMN[mm]" --set "range=COLUMN[mm]".'
    ]
