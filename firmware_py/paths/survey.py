"""Random poses of the arms, between which the platform stays held."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from deltactl.firmware_py.paths import reach
from deltactl.firmware_py.paths.path import Path
from deltactl.firmware_py.paths.shapes import through
from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.linkage import Linkage, forward, least_gain, neighbours
from deltactl.models.robot import FloatArray

LEAST_GAIN = 0.1
"""Prior: the platform moves in every direction by at least this much of the elbow's way.

Below it an error of the platform looks ten times as large at the arms, and a length that is a
percent off carries the platform through a singular pose, from which it does not come back.
"""

_DRAWN = 512
"""Triples drawn at a time: fixed, so that the sequence does not depend on the count."""

_CHAINED = 64
"""Moves looked at together: a short survey looks at few that it does not need."""

_FEWEST = 0.05
"""Give up when less than this part of the triples can be used: the lengths must be wrong."""

Spare = Callable[[FloatArray], FloatArray]
"""How far poses (n, 3) [rad] are inside of what a survey may use, (n,); negative outside."""


def off_singular(linkage: Linkage, smallest_margin: float) -> Spare:
    """Poses with a margin."""

    def spare(angles_rad: FloatArray) -> FloatArray:
        return reach.poses(linkage, angles_rad).margin - smallest_margin

    return spare


def held(linkage: Linkage, smallest_margin: float) -> Spare:
    """Poses with a margin where machines as far off as faulty ones may be keep LEAST_GAIN, too."""
    margin = off_singular(linkage, smallest_margin)
    machines = [linkage, *neighbours(linkage)]

    def spare(angles_rad: FloatArray) -> FloatArray:
        gains = [gain(one, angles_rad) for one in machines]
        return np.minimum(margin(angles_rad), np.min(gains, axis=0) - LEAST_GAIN)

    return spare


def gain(linkage: Linkage, angles_rad: FloatArray) -> FloatArray:
    """`least_gain` of commanded arm angles (n, 3) [rad]; 0 where it cannot be assembled, (n,)."""
    return least_gain(linkage, angles_rad, forward(linkage, angles_rad).position_m)


def survey(
    spare: Spare, count: int, angle_deg: tuple[float, float], dwell_s: float, seed: int
) -> Path:
    """`count` random triples in `angle_deg`. Raises UnreachablePoint if few can be used."""
    random = np.random.default_rng(seed)
    kept = np.empty((0, 3))
    drawn = 0
    while len(kept) < count:
        triples = np.deg2rad(random.uniform(*angle_deg, size=(_DRAWN, 3)))
        drawn += _DRAWN
        usable = triples[spare(triples) >= 0.0]
        for start in range(0, len(usable), _CHAINED):
            chain = _chain(spare, kept[-1:], usable[start : start + _CHAINED])
            kept = np.concatenate([kept[:-1], chain])
            if len(kept) >= count:
                break
        if len(kept) < _FEWEST * drawn:
            raise UnreachablePoint(
                f"survey: only {len(kept)} of {drawn} random arm angles in {list(angle_deg)} deg"
                " keep off singular poses (limits.singularity_margin, and machines a little off"
                " the robot file); check the robot's lengths or narrow angle_deg"
            )
    return through(kept[:count], dwell_s)


def _chain(spare: Spare, before: FloatArray, triples: FloatArray) -> FloatArray:
    """Triples less those that cannot be reached from the one before, after `before` (0 or 1)."""
    chain = np.concatenate([before, triples])
    bad = np.concatenate([[False], reach.least(spare, chain) < 0.0])
    while bad.any():
        # The next one may do well from here: only the first of neighbours is dropped at a time.
        dropped = bad.copy()
        dropped[1:] &= ~bad[:-1]
        again = np.flatnonzero(np.concatenate([[False], dropped[:-1]])[~dropped])
        chain, bad = chain[~dropped], bad[~dropped]
        bad[again] = _least(spare, chain[again - 1], chain[again]) < 0.0
    return chain


def _least(spare: Spare, starts: FloatArray, ends: FloatArray) -> FloatArray:
    """The least that is spare on separate moves."""
    there_and_on = np.stack([starts, ends], axis=1).reshape(-1, 3)
    return reach.least(spare, there_and_on)[::2]
