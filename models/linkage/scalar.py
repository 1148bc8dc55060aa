"""Inverse kinematics of one target in plain floats: numpy costs more than the arithmetic."""

from __future__ import annotations

import numpy as np

from foundation.errors import UnreachablePoint
from models.linkage.arms import Linkage
from models.linkage.inverse import inverse
from models.linkage.status import Status


def inverse_one(linkage: Linkage, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
    """Commanded arm angles [rad] of one target [m]. Raises UnreachablePoint."""
    angles_rad, status = inverse(linkage, np.array([x_m, y_m, z_m]))
    if status != Status.OK:
        raise UnreachablePoint(
            f"({x_m:.4f}, {y_m:.4f}, {z_m:.4f}) m: {Status(int(status)).name.lower()}"
        )
    first, second, third = angles_rad.tolist()
    return first, second, third
