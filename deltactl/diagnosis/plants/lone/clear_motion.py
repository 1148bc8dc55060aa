"""Where an axis is in clear motion and which way: at rest its friction is anything."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_dilation, binary_opening

from deltactl.diagnosis.observations.inverse_dynamics import Motion
from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray
from deltactl.diagnosis.plants.lone.options import FORCED_AXIS, LONE


def rests_of(motion: Motion, period: float) -> BoolArray:
    """Samples (n,) at which an axis rests; period: between samples, in periods of the low-pass.

    A turning point is no rest: friction changes its sign there, and passes the low-pass too.
    """
    rest = max(2, int(FORCED_AXIS.rest_periods / period))
    return np.asarray(binary_opening(_slow(motion), np.ones(rest, dtype=bool)))


def in_clear_motion(motion: Motion, period: float) -> BoolArray:
    """Samples (n,) in motion, away from rests and from the ends of a stretch."""
    reach = max(1, int(FORCED_AXIS.smeared_periods / period))
    smeared = binary_dilation(rests_of(motion, period), np.ones(2 * reach + 1, dtype=bool))
    return np.asarray(motion.settled & ~_slow(motion) & ~smeared)


def _slow(motion: Motion) -> BoolArray:
    """Samples (n,) at which an axis may rest."""
    slowest = OBSERVATIONS.slowest_share * motion.top_speed
    clearly = max(FORCED_AXIS.resolved * motion.velocity_noise, slowest)
    return np.asarray(np.abs(motion.velocity) <= clearly)


def rows_apart(period: float) -> int:
    """Samples between rows that count: nearer ones repeat each other."""
    return max(1, int(FORCED_AXIS.periods_a_row / period))


def alike(velocity: FloatArray, changing: FloatArray, rows: IntArray, period: float) -> IntArray:
    """Small numbers (n,): rows of one number have one noise.

    Between two samples an effort that changes fast may be anything, and near a reversal bearings
    first yield, which no curve over the speed says.
    """
    steep, count = np.abs(changing), len(rows)
    fewest = LONE.rows_a_piece
    shares = [one for one in FORCED_AXIS.steeper if (1.0 - one) * count >= fewest]
    edges = np.quantile(steep[rows], shares) if shares else np.zeros(0)
    turns = np.diff(np.signbit(velocity), prepend=False)
    near = binary_dilation(turns, np.ones(2 * max(1, int(0.5 / period)) + 1, dtype=bool))
    apart = len(shares) + 1 if np.count_nonzero(near[rows]) >= fewest else 0
    return np.asarray(np.searchsorted(edges, steep) + apart * near)


def clocks_apart_s(period_s: float) -> float:
    """Usual time between effort and position, by the clocks."""
    return max(FORCED_AXIS.clocks_s, FORCED_AXIS.clocks_periods * period_s)


def direction_of(motion: Motion) -> FloatArray:
    """Way of a motion (n,), from -1 to 1: no more certain than its velocity."""
    noise = OBSERVATIONS.turning_wider**1.5 * motion.velocity_noise
    width = max(noise, FORCED_AXIS.turning_share * motion.top_speed)
    return np.asarray(np.tanh(motion.turning / width))
