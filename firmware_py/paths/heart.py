"""The level heart x = 16 sin^3 t, y = 13 cos t - 5 cos 2t - 2 cos 3t - cos 4t.

Zhao 2023 prints the heart (Figure 8) without its formula; this is the usual one. It is 32
units wide. Both the dent (t = 0, where it starts) and the tip (t = pi) are cusps: the
direction turns round, and a motion with limited acceleration all but stops there.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from deltactl.firmware_py.paths.path import Path, curve, intervals, level
from deltactl.models.robot import FloatArray

WIDTH = 32.0
_FINE = 40_001
"""Parameter values along one turn for the arc length: error below 1e-7 of the length."""


def length_m(width_m: float, turns: int) -> float:
    """Length of the path [m]."""
    return float(_arc()[1][-1]) * width_m / WIDTH * turns


def heart(
    centre_m: tuple[float, float, float], width_m: float, turns: int, spacing_m: float
) -> Path:
    """`turns` times round, from the dent, clockwise seen from above.

    `centre_m` is the middle of its box. The intervals are even in number: the tip is a target.
    """
    t, arc = _arc()
    half = intervals(length_m(width_m, 1) / 2.0, spacing_m)
    at = np.interp(np.linspace(0.0, arc[-1] / 2.0, half + 1), arc, t)
    x, y = _xy(at)
    # The left side mirrors the right one, so that the curve is symmetric and closed exactly.
    x[0] = x[-1] = 0.0
    x_turn, y_turn = np.concatenate([x, -x[-2::-1]]), np.concatenate([y, y[-2::-1]])
    scale_m = width_m / WIDTH
    once = level(centre_m, scale_m * x_turn, scale_m * (y_turn - _middle()))
    return curve(np.concatenate([once, *([once[1:]] * (turns - 1))]), spacing_m)


def _xy(t: FloatArray) -> tuple[FloatArray, FloatArray]:
    return (
        16.0 * np.sin(t) ** 3,
        13.0 * np.cos(t) - 5.0 * np.cos(2.0 * t) - 2.0 * np.cos(3.0 * t) - np.cos(4.0 * t),
    )


@cache
def _arc() -> tuple[FloatArray, FloatArray]:
    """Parameter and arc length of one turn, in units of the formula."""
    t = np.linspace(0.0, 2.0 * np.pi, _FINE)
    x, y = _xy(t)
    return t, np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])


@cache
def _middle() -> float:
    """Middle of the heart's box in y: between the tip at -17 and the top of the lobes."""
    # dy/dt = 0 away from the cusps: 32 c^3 + 24 c^2 + 4 c - 19 = 0 with c = cos t.
    roots = np.roots([32.0, 24.0, 4.0, -19.0])
    top = np.arccos(roots[np.abs(roots.imag) < 1e-9].real)
    return (float(_xy(top)[1].max()) - 17.0) / 2.0
