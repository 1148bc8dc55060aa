"""Both kinematics of one pose in plain floats: a numpy call costs more than the arithmetic.

Same closed forms and same refusals as `deltactl.models.linkage.kinematics`, which explains them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from math import atan2, sqrt
from typing import NoReturn

import numpy as np

from deltactl.foundation.errors import Refusal, UnreachablePoint
from deltactl.models.linkage.arms import STATUS_TEXT, Linkage, Status
from deltactl.models.linkage.kinematics import inverse
from deltactl.models.linkage.vectors import Vector

LEVELS, DIRECTIONS, RADII = 1001, 36, 120


def in_reach(linkage: Linkage, x_m: float, y_m: float, z_m: float) -> str:
    """Which heights [mm] are in reach at x, y [m]; where none is, which circles are."""
    longest_m = float(np.max(linkage.upper_arm_m) + np.max(linkage.forearm_m))
    levels_m = np.linspace(-longest_m, longest_m, LEVELS)
    places = np.stack([np.full(LEVELS, x_m), np.full(LEVELS, y_m), levels_m], axis=1)
    good_m = levels_m[inverse(linkage, places).status == Status.OK]
    if not len(good_m):
        circle = _widest_circle(linkage, min(longest_m, math.hypot(x_m, y_m)), z_m)
        return f"at this x and y no z is in reach{circle}"
    span = f"z from {1e3 * good_m[0]:.0f} to {1e3 * good_m[-1]:.0f} mm is in reach"
    below = good_m[0] <= -z_m <= good_m[-1] < z_m
    meant = f" (did you mean z = {-1e3 * z_m:.6g} mm?)" if below else ""
    return f"at this x and y, {span}, negative below the base{meant}"


def _widest_circle(linkage: Linkage, radius_m: float, z_m: float) -> str:
    """The widest circle around the middle that is whole in reach at a height, below a radius."""
    radii_m = np.linspace(0.0, radius_m, RADII)
    turns_rad = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)
    x_m = radii_m[:, None] * np.cos(turns_rad)
    y_m = radii_m[:, None] * np.sin(turns_rad)
    places = np.stack([x_m, y_m, np.full_like(x_m, z_m)], axis=-1)
    whole = (inverse(linkage, places).status == Status.OK).all(axis=1)
    within = len(whole) if whole.all() else int(np.argmin(whole))
    if within < 2:
        return ""
    widest_mm = math.floor(1e3 * float(radii_m[within - 1]))
    return f"; around the middle, at this z, circles of up to {widest_mm} mm radius are"


def inverse_one(linkage: Linkage, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
    """Commanded arm angles [rad] of one target [m].

    Raises UnreachablePoint where `inverse` would not say OK, and ValueError for a linkage
    that differs from pose to pose.
    """
    plain = linkage.plain
    z2 = z_m * z_m
    angles, fx, fy, fz = [], [], [], []
    for arm in plain.arms:
        east, north, radius_m, upper_arm_m, upper2_less_forearm2, half, edge, offset_rad = arm
        u = east * x_m + north * y_m - radius_m
        v = east * y_m - north * x_m
        r2 = u * u + z2
        k = (r2 + v * v + upper2_less_forearm2) * half
        h2 = r2 - k * k
        if not h2 >= edge:  # also when it is NaN
            _refuse(linkage, x_m, y_m, z_m)
        h = sqrt(h2)
        minus_sine = z_m * k + u * h
        cosine = u * k - z_m * h
        angles.append(atan2(-minus_sine, cosine) - offset_rad)
        scale = upper_arm_m / r2
        outward = u - cosine * scale
        fx.append(east * outward - north * v)
        fy.append(north * outward + east * v)
        fz.append(z_m - minus_sine * scale)
    if not _is_below_elbows(fx, fy, fz, plain.least_volume_m3, plain.least_turn_m2):
        _refuse(linkage, x_m, y_m, z_m)
    first, second, third = angles
    return first, second, third


def _is_below_elbows(
    x: list[float], y: list[float], z: list[float], least_volume_m3: float, least_turn_m2: float
) -> bool:
    """Whether forearms x, y, z leave the platform well below the plane of its elbows."""
    x1, x2, x3 = x
    y1, y2, y3 = y
    z1, z2, z3 = z
    ax, ay, az = x1 - x2, y1 - y2, z1 - z2
    bx, by, bz = x1 - x3, y1 - y3, z1 - z3
    turn = ax * by - ay * bx
    volume = x1 * (ay * bz - az * by) + y1 * (az * bx - ax * bz) + z1 * turn
    depth = -volume if turn > 0.0 else volume
    return abs(turn) >= least_turn_m2 and depth >= least_volume_m3


def _refuse(linkage: Linkage, x_m: float, y_m: float, z_m: float) -> NoReturn:
    status = Status(int(inverse(linkage, np.array([x_m, y_m, z_m])).status))
    # A pose within rounding of the limit can be OK in one form and not in the other.
    reason = STATUS_TEXT[Status.SINGULAR if status == Status.OK else status]
    in_mm = _words(1e3 * x_m, 1e3 * y_m, 1e3 * z_m)
    instead = in_reach(linkage, x_m, y_m, z_m)
    error = UnreachablePoint(
        f"target {_words(x_m, y_m, z_m)} m is {reason} (that is {in_mm} mm; {instead}; {UNITS})"
    )
    # Who names the place as it was typed need say neither the place again nor in which units.
    error.at_point = Refusal(f"{reason} ({instead})", remedy="")
    raise error


UNITS = "job files are in m, goto is in mm"


def _words(*values: float) -> str:
    """'(0.5, 0, -0.25)', without what rounding left of a zero."""
    return f"({', '.join(f'{round(value, 9):z.6g}' for value in values)})"


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


def counted_pose(
    counts: Sequence[int], rad_per_step: float, position_of: Callable[[Vector], Vector]
) -> tuple[Vector, Vector | None]:
    """Arm angles [rad], and the platform's position [m]; None where it cannot be assembled.

    position_of: forward kinematics of one pose, NaN where there is none.
    """
    first, second, third = (count * rad_per_step for count in counts)
    angles_rad = (first, second, third)
    position_m = position_of(angles_rad)
    return angles_rad, position_m if all(map(math.isfinite, position_m)) else None
