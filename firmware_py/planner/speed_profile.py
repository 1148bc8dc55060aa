"""How fast a curve may be driven: the highest speed that respects all limits everywhere.

With u the curve's parameter and x = (du/dt)^2, an arm's speed is |q'| sqrt(x) and its
acceleration q'' x + q' du2/dt2, where du2/dt2 = (x1 - x0) / (2 h) on a piece of width h on
which x is linear (Bobrow, Dubowsky and Gibson 1985; forward and backward passes as in
Pham and Pham 2018). On each piece the bounds A of |q'| and B of |q''| are used:

    B max(x0, x1) + A |x1 - x0| / (2 h) <= a

which keeps the limit everywhere on the piece, not only at its ends, at the price of not
using what the two terms might cancel.
"""

from __future__ import annotations

import numpy as np

from deltactl.firmware_py.paths.path import BoolArray
from deltactl.firmware_py.planner.curve import Curve
from deltactl.models.robot import FloatArray

_BLOCK = 8192

FASTEST = 1e12
"""Bound of x where no arm moves at all: an interval takes at least a microsecond."""


def squared_rates(
    curve: Curve,
    stands: BoolArray,
    top_rate: FloatArray,
    speed_radps: float,
    acceleration_radps2: float,
) -> FloatArray:
    """x at the m + 1 ends of the pieces [1/s^2].

    stands: (m + 1,), True where the speed must be zero. top_rate: (m,), highest du/dt of
    each piece for other reasons (a platform speed).
    """
    first, second = curve.bounds()
    with np.errstate(divide="ignore", over="ignore"):
        by_speed = ((speed_radps / first) ** 2).min(axis=1)
        by_turning = (acceleration_radps2 / second).min(axis=1)
    piece = np.minimum(np.minimum(by_speed, by_turning), np.minimum(top_rate**2, FASTEST))
    cap = np.concatenate([piece[:1], np.minimum(piece[:-1], piece[1:]), piece[-1:]])
    cap[stands] = 0.0
    grip = first / (2.0 * curve.width_u[:, None])
    total = second + grip
    with np.errstate(divide="ignore", invalid="ignore"):
        free = np.where(total > 0.0, acceleration_radps2 / total, np.inf)
        keep = np.where(total > 0.0, grip / total, 0.0)
    ahead = _pass(cap, free, keep)
    return _pass(ahead[::-1], free[::-1], keep[::-1])[::-1]


def _pass(cap: FloatArray, free: FloatArray, keep: FloatArray) -> FloatArray:
    """Largest x with x[0] = cap[0], x[i] <= cap[i] and x[i+1] <= free[i] + keep[i] x[i]."""
    here = float(cap[0])
    found = np.empty_like(cap)
    found[0] = here
    # Plain floats: one step depends on the one before, and numpy would be ten times slower.
    # In blocks, because a float of its own takes four times the memory.
    for first in range(0, len(free), _BLOCK):
        part = slice(first, first + _BLOCK)
        block = []
        for top, (f1, f2, f3), (k1, k2, k3) in zip(
            cap[1:][part].tolist(), free[part].tolist(), keep[part].tolist(), strict=True
        ):
            here = min(top, f1 + k1 * here, f2 + k2 * here, f3 + k3 * here)
            block.append(here)
        found[1:][part] = block
    return found
