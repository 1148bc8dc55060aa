"""Poses that a machine a little off its file may not reach: they tell nothing reliable.

Near where the arms lie flat, a wrong length moves the platform by many times itself, and a little
more and the arms cannot be assembled at all. A fit would meet cliffs there.
"""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.plants.delta.options import DELTA_FITS
from deltactl.models.linkage import Linkage, forward, neighbours
from deltactl.models.robot import FloatArray

BoolArray = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


def fragile(linkage: Linkage, angles_rad: FloatArray) -> BoolArray:
    """Samples, of angles (n, 3) [rad], that cannot be assembled with all arms off alike; (n,)."""
    lost = np.zeros(len(angles_rad), dtype=bool)
    for other in neighbours(linkage):
        lost |= ~np.isfinite(forward(other, angles_rad).position_m[:, 0])
    few = lost.mean() <= DELTA_FITS.most_fragile
    return lost if few else np.zeros(len(angles_rad), dtype=bool)
