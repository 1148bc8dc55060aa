"""The chi-square law far into its tail."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc, gammaln

SMALLEST = 1e-290


def log_sf(gain: float, df: int) -> float:
    """Log of the chance that a chi-square of `df` degrees of freedom exceeds `gain`."""
    if gain <= 0.0 or df < 1:
        return 0.0
    chance = float(chdtrc(df, gain))
    if chance > SMALLEST:
        return float(np.log(chance))
    half = 0.5 * df
    return float((half - 1.0) * np.log(0.5 * gain) - 0.5 * gain - gammaln(half))
