"""A smooth way of the arms through all targets in short pieces, and how fast it may be driven.

Between two targets each arm follows the cubic that passes both with the tangent of its
neighbours (Catmull and Rom 1974): it meets every target exactly and turns without a kink.
At rests the tangent is one-sided, so straight lines stay straight up to their corners. The
parameter grows by the distance between targets (Yuksel, Schaefer and Keyser 2011, chordal): with
one step for each, the motion would nearly stop where near targets follow far ones.

The speed is the highest that respects all limits everywhere. With u the curve's parameter and
x = (du/dt)^2, an arm's speed is |q'| sqrt(x) and its acceleration q'' x + q' du2/dt2, where
du2/dt2 = (x1 - x0) / (2 h) on a piece of width h on which x is linear (Bobrow, Dubowsky and
Gibson 1985; forward and backward passes as in Pham and Pham 2018). On each piece the bounds A of
|q'| and B of |q''| are used:

    B max(x0, x1) + A |x1 - x0| / (2 h) <= a

which keeps the limit everywhere on the piece, not only at its ends, at the price of not
using what the two terms might cancel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.drivers.steps.contract import Int64Array
from deltactl.firmware_py.paths.path import BoolArray
from deltactl.models.robot import FloatArray

FEWEST_PIECES = 64
"""Pieces from one rest to the next: the speed is free only between pieces."""

NEAREST = 1e-6
"""Part of the usual target spacing; targets at one place still take a moment."""

LONGEST_STEPS = 8.0
"""Steps an arm makes in one piece, so that limits are kept closely on coarse paths too."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Cubics between n targets, and the m pieces they are cut into.

    The parameter u grows by `span`, (n - 1,), from target to target. start_rad, slope, bend,
    twist: (n - 1, 3), angle = start + w (slope + w (bend + w twist)) with w from 0 to 1 there.
    piece_of: (m,), the interval each piece belongs to. piece_start, width: (m,), w at its start
    and its width in w. first_piece: (n,), number of the piece that starts at a target (m for the
    last).
    """

    span: FloatArray
    start_rad: FloatArray
    slope: FloatArray
    bend: FloatArray
    twist: FloatArray
    piece_of: Int64Array
    piece_start: FloatArray
    width: FloatArray
    first_piece: Int64Array

    def angles_rad(self, interval: Int64Array, w: FloatArray) -> FloatArray:
        """Angles at a part w of intervals, both of shape (k,); shape (k, 3)."""
        w = w[:, None]
        tail = self.slope[interval] + w * (self.bend[interval] + w * self.twist[interval])
        angles: FloatArray = self.start_rad[interval] + w * tail
        return angles

    @property
    def width_u(self) -> FloatArray:
        """Width of each piece in u, (m,)."""
        return self.width * self.span[self.piece_of]

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Upper bounds of |dq/du| and |d2q/du2| on each piece, both (m, 3)."""
        of, w, h = self.piece_of, self.piece_start[:, None], self.width[:, None]
        slope, bend, twist = self.slope[of], 2.0 * self.bend[of], 6.0 * self.twist[of]
        first = np.maximum(
            np.abs(slope + w * (bend + w * twist / 2.0)),
            np.abs(slope + (w + h) * (bend + (w + h) * twist / 2.0)),
        )
        second = np.maximum(np.abs(bend + w * twist), np.abs(bend + (w + h) * twist))
        span = self.span[of][:, None]
        # A parabola rises above its chord by at most its second derivative times h^2 / 8.
        return (first + np.abs(twist) * h * h / 8.0) / span, second / span**2


def curve_through(
    angles_rad: FloatArray, rest: BoolArray, rad_per_step: float, hop_m: FloatArray
) -> Curve:
    """The curve through angles [rad] of shape (n, 3) with a standstill where `rest` (n,) says.

    hop_m: (n - 1,), how far apart the targets are in space.
    """
    hop, span = np.diff(angles_rad, axis=0), _spans(hop_m)
    leaves, arrives = _tangents(hop, span[:, None], rest)
    pieces = _pieces(hop, rest, rad_per_step)
    first_piece = np.concatenate([[0], np.cumsum(pieces)])
    piece_of = np.repeat(np.arange(len(hop)), pieces)
    return Curve(
        span=span,
        start_rad=angles_rad[:-1],
        slope=leaves,
        bend=3.0 * hop - 2.0 * leaves - arrives,
        twist=leaves + arrives - 2.0 * hop,
        piece_of=piece_of,
        piece_start=(np.arange(len(piece_of)) - first_piece[piece_of]) / pieces[piece_of],
        width=1.0 / pieces[piece_of],
        first_piece=first_piece,
    )


def _spans(hop_m: FloatArray) -> FloatArray:
    """How much the parameter grows from target to target, (n - 1,): 1 for the usual distance."""
    apart = hop_m[hop_m > 0.0]
    if not len(apart):
        return np.ones_like(hop_m)
    spans: FloatArray = np.maximum(hop_m / float(np.median(apart)), NEAREST)
    return spans


def _tangents(hop: FloatArray, span: FloatArray, rest: BoolArray) -> tuple[FloatArray, FloatArray]:
    """dq/dw at the start and at the end of each interval, (n - 1, 3); span: (n - 1, 1)."""
    climb = hop / span
    both = span[:-1] + span[1:]
    middle = (span[1:] * climb[:-1] + span[:-1] * climb[1:]) / both
    leaves, arrives = climb.copy(), climb.copy()
    leaves[1:], arrives[:-1] = middle, middle
    starts, ends = rest[:-1, None], rest[1:, None]
    # One-sided: the parabola through three targets, or the line through two.
    bend = np.diff(climb, axis=0) / both
    after = climb - span * np.concatenate([bend, np.zeros((1, hop.shape[1]))])
    before = climb + span * np.concatenate([np.zeros((1, hop.shape[1])), bend])
    leaves = np.where(starts, np.where(ends, climb, after), leaves)
    arrives = np.where(ends, np.where(starts, climb, before), arrives)
    return leaves * span, arrives * span


def _pieces(hop: FloatArray, rest: BoolArray, rad_per_step: float) -> Int64Array:
    """How many pieces each interval is cut into, (n - 1,)."""
    stretch = np.cumsum(rest[:-1]) - 1
    length = np.bincount(stretch)[stretch]
    steps = np.abs(hop).max(axis=1) / rad_per_step
    pieces = np.maximum(np.ceil(FEWEST_PIECES / length), np.ceil(steps / LONGEST_STEPS))
    whole: Int64Array = np.maximum(1, pieces).astype(np.int64)
    return whole


_BLOCK = 8192

FASTEST = 1e12
"""Bound of x where no arm moves at all: an interval takes at least a microsecond."""


def squared_rates(
    curve: Curve,
    rests: BoolArray,
    top_rate: FloatArray,
    speed_radps: float,
    acceleration_radps2: float,
) -> FloatArray:
    """x at the m + 1 ends of the pieces [1/s^2].

    rests: (m + 1,), True where the speed must be zero. top_rate: (m,), highest du/dt of
    each piece for other reasons (a platform speed).
    """
    first, second = curve.bounds()
    with np.errstate(divide="ignore", over="ignore"):
        by_speed = ((speed_radps / first) ** 2).min(axis=1)
        by_turning = (acceleration_radps2 / second).min(axis=1)
    piece = np.minimum(np.minimum(by_speed, by_turning), np.minimum(top_rate**2, FASTEST))
    cap = np.concatenate([piece[:1], np.minimum(piece[:-1], piece[1:]), piece[-1:]])
    cap[rests] = 0.0
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
