"""Rotary delta linkage: inverse and forward kinematics, Jacobian, distance to singular poses.

Frame: origin in the plane of the motor axes, z up, arm 1 along +x; an arm angle of 0 is
horizontal and positive is down. `inverse`, `forward`, `jacobian` and the margins work on
whole arrays; `inverse_one` on a single target in plain floats.
"""

from deltactl.models.linkage.arms import (
    SINGULAR_MARGIN,
    STATUS_TEXT,
    ArmAngles,
    Linkage,
    PlatformPosition,
    Status,
)
from deltactl.models.linkage.jacobian import jacobian, least_gain, parallel_margin, serial_margin
from deltactl.models.linkage.kinematics import forward, inverse
from deltactl.models.linkage.neighbours import neighbours
from deltactl.models.linkage.scalar import inverse_one

__all__ = [
    "SINGULAR_MARGIN",
    "STATUS_TEXT",
    "ArmAngles",
    "Linkage",
    "PlatformPosition",
    "Status",
    "forward",
    "inverse",
    "inverse_one",
    "jacobian",
    "least_gain",
    "neighbours",
    "parallel_margin",
    "serial_margin",
]
