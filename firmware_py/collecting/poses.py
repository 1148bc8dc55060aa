"""Which counts a survey commands, in which order."""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.firmware_py.paths.shapes import survey
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.linkage import Linkage

IntArray = np.ndarray[Any, np.dtype[np.int64]]


def survey_counts(robot: RobotFile, count: int, seed: int) -> IntArray:
    """Random counts within the arm limits (Zhao 2023, section 3), (count, 3).

    The same seed gives the same counts, a larger count adds to them. Raises UnreachablePoint.
    """
    limits = robot.limits
    path = survey(
        Linkage.of(robot.geometry), count, limits.arm_deg, 0.0, seed, limits.singularity_margin
    )
    counts: IntArray = np.rint(path.targets / robot.drive.rad_per_step).astype(np.int64)
    return counts
