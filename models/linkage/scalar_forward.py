"""Forward kinematics of one pose in plain floats: a numpy call costs more than the arithmetic.

Same closed form as `deltactl.models.linkage.forward`, which explains it.
"""

from __future__ import annotations

import math

from deltactl.models.linkage.arms import Linkage
from deltactl.models.linkage.vectors import Vector

NOWHERE: Vector = (math.nan, math.nan, math.nan)


def forward_one(linkage: Linkage, angles_rad: Vector) -> Vector:
    """Platform position [m] for commanded arm angles [rad]; NaN where it cannot be assembled.

    A pose that `forward` calls singular is given or not as it happens. Raises ValueError for a
    linkage that differs from pose to pose.
    """
    plain = linkage.plain
    x, y, z, l2 = [], [], [], []
    for arm, angle_rad in zip(plain.arms, angles_rad, strict=True):
        true_rad = angle_rad + arm.home_offset_rad
        reach_m = arm.radius_m + arm.upper_arm_m * math.cos(true_rad)
        x.append(reach_m * arm.east)
        y.append(reach_m * arm.north)
        z.append(-arm.upper_arm_m * math.sin(true_rad))
        l2.append(arm.upper_arm_m**2 - arm.upper2_less_forearm2_m2)
    ax, ay, az = x[1] - x[0], y[1] - y[0], z[1] - z[0]
    bx, by, bz = x[2] - x[0], y[2] - y[0], z[2] - z[0]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    n2 = nx * nx + ny * ny + nz * nz
    if not abs(nz) >= plain.least_turn_m2:
        return NOWHERE
    aq = 0.5 * (ax * ax + ay * ay + az * az + (l2[0] - l2[1])) / n2
    bq = 0.5 * (bx * bx + by * by + bz * bz + (l2[0] - l2[2])) / n2
    qx = aq * (by * nz - bz * ny) + bq * (ny * az - nz * ay)
    qy = aq * (bz * nx - bx * nz) + bq * (nz * ax - nx * az)
    qz = aq * (bx * ny - by * nx) + bq * (nx * ay - ny * ax)
    g = l2[0] - (qx * qx + qy * qy + qz * qz)
    if g < 0.0:
        return NOWHERE
    down = -math.copysign(math.sqrt(g / n2), nz)
    return (x[0] + qx + down * nx, y[0] + qy + down * ny, z[0] + qz + down * nz)
