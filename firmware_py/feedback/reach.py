"""How far feedback may ever move the platform from its path."""

from __future__ import annotations

from itertools import product

import numpy as np

from deltactl.firmware_py.feedback.settings import FeedbackSettings
from deltactl.models.linkage import Linkage, forward, jacobian
from deltactl.models.robot import ARMS, DeltaRobot, FloatArray, per_arm

LOOKED_AT = 500


def farthest_m(robot: DeltaRobot, settings: FeedbackSettings, angles_rad: FloatArray) -> float:
    """Largest way of the platform [m] with all arms corrected by the most, over a path (n, 3).

    Whatever the sensors say: `most_m` bounds each arm, here the arms are off in the worst way.
    """
    every = max(1, len(angles_rad) // LOOKED_AT)
    linkage, looked = Linkage.of(robot.geometry), angles_rad[::every]
    slopes = jacobian(linkage, looked, forward(linkage, looked).position_m)
    most_rad = settings.most_m / per_arm(robot.geometry.upper_arm_m)
    ways = np.array(list(product((-1.0, 1.0), repeat=ARMS))) * most_rad
    moved_m = np.einsum("nij,kj->nki", slopes, ways)
    return float(np.nanmax(np.linalg.norm(moved_m, axis=2)))
