"""One position from the readings of three sensors while the robot stands still."""

from __future__ import annotations

import numpy as np

from deltactl.models.robot import FloatArray, Sensors

FEWEST = 5
"""Good readings of a sensor below which a pose counts as not seen."""
OUTLIER_M = 0.015
"""Readings this far from the median are not averaged."""


def at_rest(sensors: Sensors, ranges_m: list[FloatArray]) -> FloatArray | None:
    """The position [m] (3,) for good ranges of each sensor [m] (n,); None when one saw too little.

    The mean of what lies near the median: readings come in whole millimetres, and a few are wrong
    by centimetres.
    """
    means = np.empty(3)
    for sensor, values in enumerate(ranges_m):
        if len(values) < FEWEST:
            return None
        near = np.abs(values - np.median(values)) <= OUTLIER_M
        means[sensor] = values[near].mean()
    position: FloatArray = np.linalg.solve(sensors.axes, means - sensors.offsets_m)
    return position
