"""Whether what is left of an axis comes back each time it passes a place, and in what detail.

Noise differs from pass to pass, whatever its memory; an error of the machine, or of the surface
that a sensor looks at, does not. So the mean of each visit to a place is multiplied with those of
the other visits there: the mean product is the variance of what repeats, and noise adds nothing to
it. What it comes to by chance is seen by the same residual shifted in time against the places,
which leaves its memory and the motion as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.foundation.scatter import MAD_TO_SIGMA


@dataclass(frozen=True, slots=True)
class Repeats:
    """Number of cells of the travel in which the residual repeats, and the size of that part."""

    cells: int
    size: float


def repeats(left: FloatArray, at: FloatArray, groups: IntArray, finest: float) -> Repeats | None:
    """Repeats in the residual (m,) at places (m,) in the order of time; None where it does not
    repeat.

    groups: (m,) stretches. finest: cells of the travel beyond which the readings are too few.
    """
    span = float(np.ptp(at))
    if len(left) < EVIDENCE.fewest_repeated or not span > 0.0:
        return None
    left = left - left.mean()
    offsets = np.linspace(0.05, 0.95, EVIDENCE.repeat_shifts) * len(left)
    shifted = np.stack([left, *(np.roll(left, int(n)) for n in offsets)], axis=1)
    found: list[Repeats] = []
    cells = EVIDENCE.coarsest_cells
    while cells <= finest:
        cell = np.minimum(((at - at.min()) * (cells / span)).astype(np.intp), cells - 1)
        shared = _shared_power(shifted, cell, groups, cells)
        if shared is not None and _stands_out(shared) and shared[0] > _least(left):
            found.append(Repeats(cells, float(np.sqrt(shared[0]))))
        cells *= 2
    most = max((one.size for one in found), default=0.0)
    return next((one for one in found if one.size >= EVIDENCE.most_of_repeats * most), None)


def _shared_power(
    left: FloatArray, cell: IntArray, groups: IntArray, cells: int
) -> FloatArray | None:
    """Mean product (d,) of different visits to a cell, of columns (m, d); None: too few visits."""
    begins = np.flatnonzero(np.diff(cell, prepend=-1) | np.diff(groups, prepend=-1))
    rows = np.diff(begins, append=len(cell))
    means = np.add.reduceat(left, begins, axis=0) / rows[:, None]
    visited = cell[begins]
    visits = np.bincount(visited, minlength=cells)
    pairs = visits * (visits - 1.0)
    if np.mean(visits >= EVIDENCE.fewest_visits) < EVIDENCE.share_visited:
        return None
    total = np.zeros((cells, left.shape[1]))
    square = np.zeros_like(total)
    np.add.at(total, visited, means)
    np.add.at(square, visited, means**2)
    weight = np.where(visits > 1, 1.0 / np.maximum(visits - 1.0, 1.0), 0.0)
    power: FloatArray = weight @ (total**2 - square) / float(weight @ pairs)
    return power


def _stands_out(shared: FloatArray) -> bool:
    chance = shared[1:]
    middle = float(np.median(chance))
    scatter = MAD_TO_SIGMA * float(np.median(np.abs(chance - middle)))
    return bool(shared[0] - middle > EVIDENCE.repeats_at_sigma * max(scatter, 1e-300))


def _least(left: FloatArray) -> float:
    return EVIDENCE.least_repeated * float(np.mean(left**2))
