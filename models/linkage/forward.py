"""Forward kinematics: arm angles to platform position, the meeting point of three spheres.

With the platform's radius taken off the base's, each forearm ends in the platform point:
the point lies on three spheres about the elbows (Zsombor-Murray 2004 on Clavel's delta).
Seen from elbow 1, with a and b the vectors to elbows 2 and 3 and n = a x b, it is q +- h n with

    q = ((a . q) b x n + (b . q) n x a) / n^2,    h^2 = (l1^2 - q^2) / n^2

where a . q and b . q follow from the differences of the spheres' equations.
"""

from __future__ import annotations

import numpy as np

from deltactl.models.cosine_sine import cosine_and_sine
from deltactl.models.linkage.arms import Linkage
from deltactl.models.linkage.blocks import Block, Poses, Rows
from deltactl.models.linkage.status import PlatformPosition
from deltactl.models.robot import FloatArray


def forward(linkage: Linkage, angles_rad: FloatArray) -> PlatformPosition:
    """Platform positions [m] for commanded arm angles [rad] of shape (..., 3).

    The lower of the two meeting points. It is given for elbows on the inner side too
    (`serial_margin` tells). SINGULAR are poses where the platform lies in the plane of its
    elbows, and, with NaN for values, those whose elbows lie in one vertical plane (which
    point is lower is undecided) or coincide. Raises ValueError when the last dimension is not 3.
    """
    poses = Poses(linkage, angles_rad)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for block in poses.blocks():
            _solve(block)
    return PlatformPosition(*poses.results())


def _solve(block: Block) -> None:
    rows = block.rows
    x, y, z = _elbows(rows, block.given)
    ax, ay, az = x[1] - x[0], y[1] - y[0], z[1] - z[0]
    bx, by, bz = x[2] - x[0], y[2] - y[0], z[2] - z[0]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    n2 = nx * nx + ny * ny + nz * nz
    a2 = ax * ax + ay * ay + az * az
    b2 = bx * bx + by * by + bz * bz
    l2 = rows.forearm2_m2
    aq = 0.5 * (a2 + (l2[0] - l2[1])) / n2
    bq = 0.5 * (b2 + (l2[0] - l2[2])) / n2
    qx = aq * (by * nz - bz * ny) + bq * (ny * az - nz * ay)
    qy = aq * (bz * nx - bx * nz) + bq * (nz * ax - nx * az)
    qz = aq * (bx * ny - by * nx) + bq * (nx * ay - ny * ax)
    g = l2[0] - (qx * qx + qy * qy + qz * qz)
    down = -np.copysign(np.sqrt(np.maximum(g, 0.0) / n2), nz)
    block.result[0] = x[0] + qx + down * nx
    block.result[1] = y[0] + qy + down * ny
    block.result[2] = z[0] + qz + down * nz

    volume2 = g * n2
    least2 = rows.least_volume_m3 * rows.least_volume_m3
    decided = np.abs(nz) >= rows.least_turn_m2
    sure = decided & (volume2 >= least2)
    if not sure.all():
        known = np.isfinite(block.given).all(axis=0)
        block.mark(sure, possible=known & ~(volume2 <= -least2))
        block.result[:, ~decided] = np.nan


def _elbows(rows: Rows, angles_rad: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Elbows less the platform's radius, as rows x, y, z [m] of shape (3, n)."""
    true_rad = angles_rad + rows.home_offset_rad
    cosine, sine = cosine_and_sine(true_rad)
    reach_m = rows.radius_m + rows.upper_arm_m * cosine
    return reach_m * rows.east, reach_m * rows.north, -rows.upper_arm_m * sine
