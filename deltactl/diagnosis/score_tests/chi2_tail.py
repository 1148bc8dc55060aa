"""The chi-square law far into its tail."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc, gammaln

from deltactl.diagnosis.observations.readings import FloatArray, IntArray

SMALLEST = 1e-290


def log_sf(gain: float, df: int) -> float:
    """Log of the chance that a chi-square of `df` degrees of freedom exceeds `gain`."""
    return float(log_sfs(np.asarray(gain), np.asarray(df)))


def log_sfs(gain: FloatArray, df: IntArray) -> FloatArray:
    """The same for many, of one shape."""
    known = (gain > 0.0) & (df >= 1)
    x, half = np.where(known, gain, 1.0), 0.5 * np.where(known, df, 1)
    chance = chdtrc(2.0 * half, x)
    tail = (half - 1.0) * np.log(0.5 * x) - 0.5 * x - gammaln(half)
    log = np.where(chance > SMALLEST, np.log(np.maximum(chance, SMALLEST)), tail)
    return np.where(known, log, 0.0)
