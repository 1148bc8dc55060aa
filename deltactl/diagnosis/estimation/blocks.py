"""Blocks of time: what is summed over one is independent of the next, whatever the noise."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.observations.readings import IntArray


def blocks_of(fitter: Fitter) -> IntArray:
    """Number of the block of time each whitened reading lies in, (m,)."""
    t_s = fitter.model.readings.t_s[fitter.whiten.rows]
    length = max(ESTIMATION.block_s, ESTIMATION.fewest_in_block * fitter.model.readings.period_s)
    return np.asarray((t_s - t_s.min()) / length, dtype=np.intp)
