"""A level circle."""

from __future__ import annotations

import math

import numpy as np

from deltactl.firmware_py.paths.path import Path, curve, intervals, level


def length_m(radius_m: float, turns: float) -> float:
    """Length of the path [m]."""
    return 2.0 * math.pi * radius_m * abs(turns)


def circle(
    centre_m: tuple[float, float, float], radius_m: float, turns: float, spacing_m: float
) -> Path:
    """`turns` times round from the +x side, counter-clockwise from above if positive.

    Whole turns pass the same points every time and close exactly.
    """
    if float(turns).is_integer():
        per_turn = intervals(length_m(radius_m, 1.0), spacing_m)
        turn = np.arange(int(abs(turns)) * per_turn + 1) % per_turn / per_turn
        turn *= math.copysign(1.0, turns)
    else:
        turn = np.linspace(0.0, turns, intervals(length_m(radius_m, turns), spacing_m) + 1)
    angle_rad = 2.0 * np.pi * turn
    x_m, y_m = radius_m * np.cos(angle_rad), radius_m * np.sin(angle_rad)
    return curve(level(centre_m, x_m, y_m), spacing_m)
