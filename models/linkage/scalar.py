"""Inverse kinematics of one target in plain floats: a numpy call costs more than the arithmetic.

Same closed form and same refusals as `deltactl.models.linkage.inverse`, which explains them.
"""

from __future__ import annotations

from math import atan2, sqrt
from typing import NoReturn

import numpy as np

from deltactl.foundation.errors import Refusal, UnreachablePoint
from deltactl.models.linkage.arms import Linkage
from deltactl.models.linkage.inverse import inverse
from deltactl.models.linkage.reach_in_words import in_reach
from deltactl.models.linkage.status import STATUS_TEXT, Status


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
