"""Random arm angles, as Zhao 2023 section 3 collects the data its networks learn from.

Not every triple of angles can be used: of uniform triples in [-20, 110] degrees of the Zhao
robot 1.8 % lie beyond a serial singularity (a forearm folded through its upper arm's plane).
A triple whose pose cannot be assembled or comes nearer to singular than the robot file's
`limits.singularity_margin`, or that cannot be had from the one before it without doing so on
the way, is skipped and the next one drawn. The angles are therefore uniform on what can be
reached, not on the whole cube. The same seed gives the same angles; a larger count adds to them.
"""

from __future__ import annotations

import numpy as np

from deltactl.firmware_py.paths import reach
from deltactl.firmware_py.paths.joints import through
from deltactl.firmware_py.paths.path import Path
from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.linkage import Linkage
from deltactl.models.robot import FloatArray

_DRAWN = 512
"""Triples drawn at a time: fixed, so that the sequence does not depend on the count."""

_FEWEST = 0.05
"""Give up when less than this part of the triples can be used: the lengths must be wrong."""


def survey(
    linkage: Linkage,
    count: int,
    angle_deg: tuple[float, float],
    dwell_s: float,
    seed: int,
    smallest_margin: float,
) -> Path:
    """`count` random triples in `angle_deg`. Raises UnreachablePoint if few can be used."""
    random = np.random.default_rng(seed)
    kept = np.empty((0, 3))
    drawn = 0
    while len(kept) < count:
        triples = np.deg2rad(random.uniform(*angle_deg, size=(_DRAWN, 3)))
        drawn += _DRAWN
        usable = triples[reach.poses(linkage, triples).margin >= smallest_margin]
        kept = np.concatenate([kept[:-1], _chain(linkage, kept[-1:], usable, smallest_margin)])
        if len(kept) < _FEWEST * drawn:
            raise UnreachablePoint(
                f"survey: only {len(kept)} of {drawn} random arm angles in {list(angle_deg)} deg"
                f" can be used (singularity margin {smallest_margin:g}); check the robot's lengths"
                " or narrow angle_deg"
            )
    return through(kept[:count], dwell_s)


def _chain(
    linkage: Linkage, before: FloatArray, triples: FloatArray, smallest_margin: float
) -> FloatArray:
    """Triples less those that cannot be reached from the one before, after `before` (0 or 1)."""
    chain = np.concatenate([before, triples])
    bad = np.concatenate([[False], reach.moves(linkage, chain).margin < smallest_margin])
    while bad.any():
        # The next one may do well from here: only the first of neighbours is dropped at a time.
        dropped = bad.copy()
        dropped[1:] &= ~bad[:-1]
        again = np.flatnonzero(np.concatenate([[False], dropped[:-1]])[~dropped])
        chain, bad = chain[~dropped], bad[~dropped]
        bad[again] = _margins(linkage, chain[again - 1], chain[again]) < smallest_margin
    return chain


def _margins(linkage: Linkage, starts: FloatArray, ends: FloatArray) -> FloatArray:
    """Smallest margins of separate moves."""
    there_and_on = np.stack([starts, ends], axis=1).reshape(-1, 3)
    return reach.moves(linkage, there_and_on).margin[::2]
