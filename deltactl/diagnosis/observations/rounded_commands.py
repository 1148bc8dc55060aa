"""Commands that a log rounds as it rounds the readings: a drive got smoother ones.

Any drive that is late or yields smooths what it gets, so it would explain the rounding.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import minimum_filter1d
from scipy.signal import savgol_filter

from deltactl.diagnosis.observations.readings import FloatArray, IntArray

REACHES = (2, 4, 8)
"""Rows to either side of the cubics that are tried, the shortest first."""
HALF = 0.5 * (1.0 + 1e-6)
"""Share of a step that rounding takes off."""


def unrounded(values: FloatArray, step: float, groups: IntArray) -> FloatArray:
    """A course (n,) as smooth as its rounding to a step allows.

    A cubic (Savitzky and Golay 1964, Anal. Chem. 36, 1627-1639) takes the place of a row where all
    rows that it is fitted to lie within half a step of such cubics. groups: (n,) numbers of the
    stretches.
    """
    smooth = values.copy()
    ends = np.flatnonzero(np.diff(groups)) + 1
    for rows in np.split(np.arange(len(values)), ends):
        own = values[rows]
        for reach in REACHES:
            width = 2 * reach + 1
            if len(own) < width:
                break
            cubic = savgol_filter(own, width, 3)
            near = np.abs(cubic - own) <= HALF * step
            whole = minimum_filter1d(near.astype(np.intp), width) > 0
            smooth[rows[whole]] = cubic[whole]
    return smooth
