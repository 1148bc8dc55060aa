"""Errors of a log: stamps off the beat of the readings, commands rounded as the readings are.

A logger stamps a reading late, or to a millisecond; the reading was mostly taken on a steady beat.
A stamp off its beat is then error in part, and a position read at speed shows in which: it follows
the share of the offsets that is true (regression calibration: Carroll et al. 2006, Measurement
Error in Nonlinear Models, chapter 4). And a drive got smoother commands than a log of whole counts
has: any drive that is late or yields smooths what it gets, so it would explain the rounding.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.ndimage import minimum_filter1d

from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray

CLEARER = 0.98
"""Roughness of a motion, of that by its stamps, from which on another course of time counts: a
median of 400 values or more is known to 2 % or better."""
REACHES = (2, 4, 8)
"""Rows to either side of the cubics that are tried, the shortest first."""
HALF = 0.5 * (1.0 + 1e-6)
"""Share of a step that rounding takes off."""


def sampling_times(t_s: FloatArray, fresh: BoolArray, position: FloatArray) -> FloatArray:
    """Times (n,) at which positions (n,) were most likely read, from their stamps (n,).

    fresh: (n,) where a stretch begins. The stamps themselves where those make the motion as smooth.
    """
    from scipy.optimize import minimize_scalar  # takes 0.1 s to import

    ends = [*np.flatnonzero(fresh).tolist(), len(t_s)]
    period_s = float(np.median(np.diff(t_s)))
    beat_s = t_s.copy()
    for part in (slice(a, b) for a, b in pairwise(ends)):
        if part.stop - part.start > 2:
            beat_s[part] = _beat(t_s[part], period_s)
    off_s = t_s - beat_s
    rows = np.arange(len(t_s) - 4)[:, None] + np.arange(5)
    rows = rows[~fresh[rows[:, 1:]].any(axis=1)]
    if not len(rows) or not float(np.abs(off_s).max()) > 0.0:
        return t_s

    def rough(share: float) -> float:
        return _rough(beat_s[rows] + share * off_s[rows], position[rows])

    best = minimize_scalar(rough, bounds=(0.0, 1.0), method="bounded", options={"xatol": 0.01})
    return beat_s + float(best.x) * off_s if best.fun < CLEARER * rough(1.0) else t_s


def _rough(t_s: FloatArray, values: FloatArray) -> float:
    """How far the middle one of five values (m, 5) usually is from a cubic through the others."""
    weight = np.ones((len(t_s), 4))
    others = [0, 1, 3, 4]
    for column, one in enumerate(others):
        for other in others:
            if other != one:
                weight[:, column] *= (t_s[:, 2] - t_s[:, other]) / (t_s[:, one] - t_s[:, other])
    off = values[:, 2] - np.sum(weight * values[:, others], axis=1)
    return float(np.median(np.abs(off) / np.sqrt(1.0 + np.sum(weight**2, axis=1))))


def _beat(t_s: FloatArray, period_s: float) -> FloatArray:
    """The steady beat nearest to stamps (n,), of which some may be missing."""
    number = np.cumsum(np.concatenate([[0.0], np.maximum(np.round(np.diff(t_s) / period_s), 1.0)]))
    slope, first = np.polyfit(number, t_s, 1)
    return np.asarray(first + slope * number)


def unrounded(values: FloatArray, step: float, groups: IntArray) -> FloatArray:
    """A course (n,) as smooth as its rounding to a step allows.

    A cubic (Savitzky and Golay 1964, Anal. Chem. 36, 1627-1639) takes the place of a row where all
    rows that it is fitted to lie within half a step of such cubics. groups: (n,) numbers of the
    stretches.
    """
    from scipy.signal import savgol_filter  # takes 0.1 s to import

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
