"""Inverse kinematics: platform position to arm angles, in closed form.

In the plane of one arm let (u, z) be the platform point as seen from the motor axis, v its
distance from that plane, L the upper arm and l the forearm. The forearm's length gives

    u cos a - z sin a = k,    k = (u^2 + v^2 + z^2 + L^2 - l^2) / (2 L)

with two solutions a = atan2(-z, u) -+ acos(k / r), r^2 = u^2 + z^2. Minus is the elbow on the
outer side, the way a delta is built. With h^2 = r^2 - k^2 sine and cosine of a follow without
a further arc function, and h / l is the serial margin. (The loop is that of Zhao 2023,
section 2; the closed form is derived here.)
"""

from __future__ import annotations

import numpy as np

from deltactl.models.linkage.arms import Linkage
from deltactl.models.linkage.blocks import Block, Poses
from deltactl.models.linkage.status import SINGULAR_MARGIN, ArmAngles
from deltactl.models.robot import FloatArray


def inverse(linkage: Linkage, position_m: FloatArray) -> ArmAngles:
    """Commanded arm angles [rad] for platform positions [m] of shape (..., 3).

    Elbows on the outer side and the platform below them, so that `forward` of a pose that
    is OK gives the position back; a point that can be had only with the platform above its
    elbows is UNREACHABLE. Angles lie in (-pi, pi] before the home offset is taken off.
    Raises ValueError when the last dimension is not 3.
    """
    poses = Poses(linkage, position_m)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for block in poses.blocks():
            _solve(block)
    return ArmAngles(*poses.results())


def _solve(block: Block) -> None:
    rows, (x_m, y_m, z_m) = block.rows, block.given
    u = rows.east * x_m + rows.north * y_m - rows.radius_m
    v = rows.east * y_m - rows.north * x_m
    r2 = u * u + z_m * z_m
    k = (r2 + v * v + rows.upper2_less_forearm2_m2) * rows.half_per_upper_arm
    h2 = r2 - k * k
    h = np.sqrt(np.maximum(h2, 0.0))
    sine = -(z_m * k + u * h)
    cosine = u * k - z_m * h
    np.subtract(np.arctan2(sine, cosine), rows.home_offset_rad, out=block.result)

    scale = rows.upper_arm_m / r2
    outward = u - cosine * scale
    depth_m3, turn_m2 = _forearm_volume(
        rows.east * outward - rows.north * v,
        rows.north * outward + rows.east * v,
        sine * scale + z_m,
    )
    edge = SINGULAR_MARGIN**2 * rows.forearm2_m2
    decided = np.abs(turn_m2) >= rows.least_turn_m2
    sure = (h2 >= edge).all(axis=0) & decided & (depth_m3 >= rows.least_volume_m3)
    if not sure.all():
        above = decided & (depth_m3 <= -rows.least_volume_m3)
        block.mark(sure, possible=(h2 > -edge).all(axis=0) & ~above)


def _forearm_volume(x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Volume spanned by the forearms given as rows, positive with the platform below its elbows.

    Also twice the level area of the elbow triangle, whose sign decides what is below.
    """
    ax, ay, az = x[0] - x[1], y[0] - y[1], z[0] - z[1]
    bx, by, bz = x[0] - x[2], y[0] - y[2], z[0] - z[2]
    turn = ax * by - ay * bx
    volume = x[0] * (ay * bz - az * by) + y[0] * (az * bx - ax * bz) + z[0] * turn
    return -np.copysign(1.0, turn) * volume, turn
