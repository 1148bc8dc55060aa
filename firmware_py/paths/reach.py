"""How near to singular the platform comes, and where it goes, when the arms move in proportion."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.models.linkage import Linkage, Status, forward, parallel_margin, serial_margin
from deltactl.models.robot import FloatArray

IntArray = np.ndarray[Any, np.dtype[np.int64]]
STEP_RAD = np.deg2rad(2.0)
"""Poses along a move are at most this far apart in any arm.

Between two such poses the margin squared dips by at most 1.5e-4 times its second derivative
(of order 1 per rad^2), far less than the square of any sensible limit on the margin."""

_BLOCK = 20_000
"""Poses looked at together, to bound memory."""


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """What happens on each of n moves, ends included; arrays of shape (n,) or (n, 3)."""

    serial: FloatArray
    """Smallest serial margin: below 0 an elbow is on the wrong side."""
    parallel: FloatArray
    """Smallest parallel margin: at 0 the arms no longer hold the platform."""
    length_m: FloatArray
    """How far the platform travels."""
    steepest_m: FloatArray
    """Fastest platform travel per part of the move: metres at the rate of one move."""
    low_m: FloatArray
    high_m: FloatArray
    """Box around the platform's way."""

    @property
    def margin(self) -> FloatArray:
        """The smaller of both; negative where the linkage cannot be assembled."""
        return np.minimum(self.serial, self.parallel)


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Where commanded arm angles (n, 3) put the platform [m] (n, 3), with margins (n,).

    Margins are -1 where the linkage cannot be assembled.
    """

    position_m: FloatArray
    serial: FloatArray
    parallel: FloatArray

    @property
    def margin(self) -> FloatArray:
        """The smaller margin of each pose."""
        return np.minimum(self.serial, self.parallel)


def poses(linkage: Linkage, angles_rad: FloatArray) -> Poses:
    """Poses of commanded arm angles [rad] of shape (n, 3)."""
    pose = forward(linkage, angles_rad)
    good = pose.status == Status.OK
    serial = serial_margin(linkage, angles_rad, pose.position_m).min(axis=-1)
    parallel = parallel_margin(linkage, angles_rad, pose.position_m)
    return Poses(pose.position_m, np.where(good, serial, -1.0), np.where(good, parallel, -1.0))


def moves(linkage: Linkage, angles_rad: FloatArray) -> Reach:
    """The moves from each of the arm angles (n + 1, 3) to the next."""
    parts = [_moves(linkage, block) for block in _blocks(angles_rad)]
    if not parts:
        none, nowhere = np.empty(0), np.empty((0, 3))
        return Reach(none, none, none, none, nowhere, nowhere)
    return Reach(*(np.concatenate([getattr(p, name) for p in parts]) for name in Reach.__slots__))


def _counts(angles_rad: FloatArray) -> IntArray:
    """How many poses each move is looked at in, besides its start."""
    widest = np.abs(np.diff(angles_rad, axis=0)).max(axis=1)
    counts: IntArray = np.ceil(widest / STEP_RAD).astype(np.int64)
    return np.maximum(1, counts)


def _blocks(angles_rad: FloatArray) -> Iterator[FloatArray]:
    """Stretches of angles that share their ends, each of about _BLOCK poses along its moves."""
    if len(angles_rad) < 2:
        return
    block = np.cumsum(_counts(angles_rad)) // _BLOCK
    cuts = [0, *(np.flatnonzero(np.diff(block)) + 1), len(angles_rad) - 1]
    for start, end in itertools.pairwise(cuts):
        yield angles_rad[start : end + 1]


def _along(angles_rad: FloatArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Poses of the moves less the first start, the row of each move's first, and their counts."""
    counts = _counts(angles_rad)
    first = np.cumsum(counts) - counts
    move = np.repeat(np.arange(len(counts)), counts)
    part = (np.arange(len(move)) - first[move] + 1) / counts[move]
    along: FloatArray = angles_rad[move] + part[:, None] * np.diff(angles_rad, axis=0)[move]
    return np.concatenate([angles_rad[:1], along]), first, counts


def least(of: Callable[[FloatArray], FloatArray], angles_rad: FloatArray) -> FloatArray:
    """The smallest value of a function of poses (n, 3) on each of the moves, ends included."""
    parts = [np.empty(0)]
    for block in _blocks(angles_rad):
        along, first, _ = _along(block)
        values = of(along)
        parts.append(np.minimum(np.minimum.reduceat(values[1:], first), values[first]))
    return np.concatenate(parts)


def _moves(linkage: Linkage, angles_rad: FloatArray) -> Reach:
    along, first, counts = _along(angles_rad)
    seen = poses(linkage, along)
    position_m = seen.position_m
    hops_m: FloatArray = np.linalg.norm(np.diff(position_m, axis=0), axis=1)
    longest_m: FloatArray = np.maximum.reduceat(hops_m, first)
    return Reach(
        serial=np.minimum(np.minimum.reduceat(seen.serial[1:], first), seen.serial[first]),
        parallel=np.minimum(np.minimum.reduceat(seen.parallel[1:], first), seen.parallel[first]),
        length_m=np.add.reduceat(hops_m, first),
        steepest_m=longest_m * counts,
        low_m=np.fmin(np.fmin.reduceat(position_m[1:], first), position_m[first]),
        high_m=np.fmax(np.fmax.reduceat(position_m[1:], first), position_m[first]),
    )
