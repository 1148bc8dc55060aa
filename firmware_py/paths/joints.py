"""Arm angles one after another, straight in joint space, with a rest at each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.firmware_py.paths.path import Path, Space
from deltactl.models.robot import FloatArray


def joints(angles_deg: Sequence[tuple[float, float, float]], dwell_s: float) -> Path:
    """A path through arm angles given in degrees."""
    return through(np.deg2rad(np.asarray(angles_deg, dtype=np.float64)), dwell_s)


def through(angles_rad: FloatArray, dwell_s: float) -> Path:
    """A path through arm angles [rad] of shape (n, 3); back to the first in one move."""
    count = len(angles_rad)
    return Path(
        space=Space.JOINT,
        targets=angles_rad,
        dwell_s=np.full(count, dwell_s),
        rest=np.ones(count, dtype=np.bool_),
        way_back=np.empty((0, 3)),
    )
