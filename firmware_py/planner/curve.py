"""A smooth way of the arms through all targets, cut into short pieces.

Between two targets each arm follows the cubic that passes both with the tangent of its
neighbours (Catmull and Rom 1974): it meets every target exactly and turns without a kink.
At rests the tangent is one-sided, so straight lines stay straight up to their corners.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drivers.steps.contract import Int64Array
from firmware_py.paths.path import BoolArray
from models.robot import FloatArray

FEWEST_PIECES = 64
"""Pieces from one rest to the next: the speed is free only between pieces."""

LONGEST_STEPS = 8.0
"""Steps an arm makes in one piece, so that limits are kept closely on coarse paths too."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Cubics between n targets, and the m pieces they are cut into.

    The parameter u grows by 1 from target to target. start_rad, slope, bend, twist: (n - 1, 3),
    angle = start + w (slope + w (bend + w twist)) with w from 0 to 1. piece_of: (m,), the
    interval each piece belongs to. piece_start, width: (m,), w at its start and its width in w.
    first_piece: (n,), number of the piece that starts at a target (m for the last).
    """

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

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Upper bounds of |dq/du| and |d2q/du2| on each piece, both (m, 3)."""
        of, w, h = self.piece_of, self.piece_start[:, None], self.width[:, None]
        slope, bend, twist = self.slope[of], 2.0 * self.bend[of], 6.0 * self.twist[of]
        first = np.maximum(
            np.abs(slope + w * (bend + w * twist / 2.0)),
            np.abs(slope + (w + h) * (bend + (w + h) * twist / 2.0)),
        )
        second = np.maximum(np.abs(bend + w * twist), np.abs(bend + (w + h) * twist))
        # A parabola rises above its chord by at most its second derivative times h^2 / 8.
        return first + np.abs(twist) * h * h / 8.0, second


def curve_through(angles_rad: FloatArray, rest: BoolArray, rad_per_step: float) -> Curve:
    """The curve through angles [rad] of shape (n, 3) with a standstill where `rest` (n,) says."""
    hop = np.diff(angles_rad, axis=0)
    leaves, arrives = _tangents(hop, rest)
    pieces = _pieces(hop, rest, rad_per_step)
    first_piece = np.concatenate([[0], np.cumsum(pieces)])
    piece_of = np.repeat(np.arange(len(hop)), pieces)
    return Curve(
        start_rad=angles_rad[:-1],
        slope=leaves,
        bend=3.0 * hop - 2.0 * leaves - arrives,
        twist=leaves + arrives - 2.0 * hop,
        piece_of=piece_of,
        piece_start=(np.arange(len(piece_of)) - first_piece[piece_of]) / pieces[piece_of],
        width=1.0 / pieces[piece_of],
        first_piece=first_piece,
    )


def _tangents(hop: FloatArray, rest: BoolArray) -> tuple[FloatArray, FloatArray]:
    """dq/du at the start and at the end of each interval, (n - 1, 3)."""
    middle = (hop[:-1] + hop[1:]) / 2.0
    leaves, arrives = hop.copy(), hop.copy()
    leaves[1:], arrives[:-1] = middle, middle
    starts, ends = rest[:-1, None], rest[1:, None]
    # One-sided: the parabola through three targets, or the line through two.
    after = np.concatenate([hop[1:], hop[-1:]])
    before = np.concatenate([hop[:1], hop[:-1]])
    leaves = np.where(starts, np.where(ends, hop, 1.5 * hop - 0.5 * after), leaves)
    arrives = np.where(ends, np.where(starts, hop, 1.5 * hop - 0.5 * before), arrives)
    return leaves, arrives


def _pieces(hop: FloatArray, rest: BoolArray, rad_per_step: float) -> Int64Array:
    """How many pieces each interval is cut into, (n - 1,)."""
    stretch = np.cumsum(rest[:-1]) - 1
    length = np.bincount(stretch)[stretch]
    steps = np.abs(hop).max(axis=1) / rad_per_step
    pieces = np.maximum(np.ceil(FEWEST_PIECES / length), np.ceil(steps / LONGEST_STEPS))
    whole: Int64Array = np.maximum(1, pieces).astype(np.int64)
    return whole
