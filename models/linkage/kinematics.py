"""Both kinematics of many poses, in closed form.

Forward kinematics: arm angles to platform position, the meeting point of three spheres.

With the platform's radius taken off the base's, each forearm ends in the platform point:
the point lies on three spheres about the elbows (Zsombor-Murray 2004 on Clavel's delta).
Seen from elbow 1, with a and b the vectors to elbows 2 and 3 and n = a x b, it is q +- h n with

    q = ((a . q) b x n + (b . q) n x a) / n^2,    h^2 = (l1^2 - q^2) / n^2

where a . q and b . q follow from the differences of the spheres' equations.

Inverse kinematics: platform position to arm angles, in closed form.

In the plane of one arm let (u, z) be the platform point as seen from the motor axis, v its
distance from that plane, L the upper arm and l the forearm. The forearm's length gives

    u cos a - z sin a = k,    k = (u^2 + v^2 + z^2 + L^2 - l^2) / (2 L)

with two solutions a = atan2(-z, u) -+ acos(k / r), r^2 = u^2 + z^2. Minus is the elbow on the
outer side, the way a delta is built. With h^2 = r^2 - k^2 sine and cosine of a follow without
a further arc function, and h / l is the serial margin. (The loop is that of Zhao 2023,
section 2; the closed form is derived here.)

Poses in blocks that stay in the processor's cache, one row an arm or axis.

The closed forms are written on rows of up to BLOCK poses, so that every intermediate value
is still in the second-level cache when it is used: three times faster than whole arrays.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from deltactl.models.linkage.arms import (
    SINGULAR_MARGIN,
    ArmAngles,
    Linkage,
    PlatformPosition,
    Status,
    StatusArray,
)
from deltactl.models.linkage.vectors import cosine_and_sine
from deltactl.models.robot import ARMS, FloatArray

BLOCK = 2048

Mask = np.ndarray[Any, np.dtype[np.bool_]]


class Rows(NamedTuple):
    """A linkage for one block: values of shape (3, 1), or (3, n) where poses differ."""

    east: FloatArray
    """Cosine of the azimuth."""
    north: FloatArray
    """Sine of the azimuth."""
    radius_m: FloatArray
    upper_arm_m: FloatArray
    home_offset_rad: FloatArray
    forearm2_m2: FloatArray
    upper2_less_forearm2_m2: FloatArray
    half_per_upper_arm: FloatArray
    least_volume_m3: FloatArray
    """Volume spanned by the forearms below which a pose is singular, (1,) or (n,)."""
    least_turn_m2: FloatArray
    """Level area of the elbow triangle (twice) below which 'lower' is undecided, likewise."""


class Block(NamedTuple):
    """One block of poses and where its results go."""

    rows: Rows
    given: FloatArray
    """Positions or angles, (3, n), contiguous."""
    result: FloatArray
    """View of shape (3, n) into the results."""
    status: StatusArray
    """View of shape (n,) into the status codes, OK until marked."""

    def mark(self, sure: Mask, possible: Mask) -> None:
        """Sure poses are OK, possible ones SINGULAR, and the rest UNREACHABLE and NaN."""
        self.status[:] = np.where(possible, Status.SINGULAR, Status.UNREACHABLE)
        self.status[sure] = Status.OK
        self.result[:, self.status == Status.UNREACHABLE] = np.nan


class Poses:
    """An array of poses (..., 3) with its results, walked block by block."""

    def __init__(self, linkage: Linkage, given: FloatArray):
        given = np.asarray(given, dtype=np.float64)
        if given.shape[-1:] != (ARMS,):
            raise ValueError(f"poses must have shape (..., 3), got {given.shape}")
        values = linkage.values()
        self._shape = np.broadcast_shapes(given.shape, *(value.shape for value in values))
        self._varying = not linkage.is_constant
        self._values = [self._flat(value) for value in values] if self._varying else list(values)
        self._given = self._flat(given)
        self._result = np.empty((len(self._given), ARMS))
        self._status: StatusArray = np.zeros(len(self._given), dtype=np.uint8)

    def blocks(self) -> Iterator[Block]:
        """The poses in order, as rows."""
        rows = None if self._varying else rows_of(*self._values)
        for start in range(0, len(self._given), BLOCK):
            part = slice(start, start + BLOCK)
            yield Block(
                rows=rows or rows_of(*(value[part] for value in self._values)),
                given=np.ascontiguousarray(self._given[part].T),
                result=self._result[part].T,
                status=self._status[part],
            )

    def results(self) -> tuple[FloatArray, StatusArray]:
        """Values (..., 3) and status codes (...) of all poses."""
        return self._result.reshape(self._shape), self._status.reshape(self._shape[:-1])

    def _flat(self, value: FloatArray) -> FloatArray:
        return np.broadcast_to(value, self._shape).reshape(-1, ARMS)


def rows_of(
    radius_m: FloatArray,
    upper_arm_m: FloatArray,
    forearm_m: FloatArray,
    azimuth_rad: FloatArray,
    home_offset_rad: FloatArray,
) -> Rows:
    """Values an arm, of shape (3,) or (n, 3), as rows."""
    return Rows(
        east=_row(np.cos(azimuth_rad)),
        north=_row(np.sin(azimuth_rad)),
        radius_m=_row(radius_m),
        upper_arm_m=_row(upper_arm_m),
        home_offset_rad=_row(home_offset_rad),
        forearm2_m2=_row(forearm_m**2),
        upper2_less_forearm2_m2=_row(upper_arm_m**2 - forearm_m**2),
        half_per_upper_arm=_row(0.5 / upper_arm_m),
        least_volume_m3=np.atleast_1d(SINGULAR_MARGIN * forearm_m.prod(axis=-1)),
        least_turn_m2=np.atleast_1d(SINGULAR_MARGIN * forearm_m.max(axis=-1) ** 2),
    )


def _row(value: FloatArray) -> FloatArray:
    return np.ascontiguousarray(np.atleast_2d(value).T)


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
            _solve_forward(block)
    return PlatformPosition(*poses.results())


def _solve_forward(block: Block) -> None:
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
            _solve_inverse(block)
    return ArmAngles(*poses.results())


def _solve_inverse(block: Block) -> None:
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
