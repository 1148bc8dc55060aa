"""Signals of a recording some seconds later: what an effort shows of a motion that comes late."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray

SPLINE = 5
"""Degree of the splines. Where the low-pass ends, at five samples a period, two slopes of cubic
splines make a mass 3 % smaller, two of these 0.3 %."""


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """Values (n, ...) with their first and second derivative by time."""

    values: FloatArray
    slopes: FloatArray
    bends: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Between:
    """Cubic Hermite weights (n, 1) of the two rows between which a moment is."""

    row: IntArray
    of_values: tuple[FloatArray, FloatArray]
    of_slopes: tuple[FloatArray, FloatArray]


class AheadInTime:
    """Signals at the rows of a recording, each stretch by itself."""

    def __init__(self, t_s: FloatArray, fresh: BoolArray):
        self._t_s = t_s
        starts = [*np.flatnonzero(fresh).tolist(), len(t_s)]
        self._stretches = [slice(a, b) for a, b in pairwise(starts) if b - a > SPLINE]
        self._between = lru_cache(maxsize=4)(self._weights)

    def curves(self, values: FloatArray) -> Curves:
        """Derivatives of values (n, ...) by splines; zero in a stretch too short for one, and where
        values are beyond what a number can hold.
        """
        from scipy.interpolate import make_interp_spline  # takes 0.3 s to import

        found = Curves(values, np.zeros_like(values), np.zeros_like(values))
        for part in self._stretches:
            if not np.isfinite(values[part]).all():
                continue
            spline = make_interp_spline(self._t_s[part], values[part], SPLINE)
            found.slopes[part] = spline(self._t_s[part], 1)
            found.bends[part] = spline(self._t_s[part], 2)
        return found

    def later(self, curves: Curves, dead_s: float, time_s: float) -> FloatArray:
        """What becomes the values (n, k) behind a dead time and a first-order lag; of a dead time
        below zero, what the values were.
        """
        at = self._between(dead_s)
        values = curves.values + time_s * curves.slopes
        slopes = curves.slopes + time_s * curves.bends
        found: FloatArray = at.of_values[0] * values.take(at.row, axis=0)
        found += at.of_slopes[0] * slopes.take(at.row, axis=0)
        found += at.of_values[1] * values.take(at.row + 1, axis=0)
        found += at.of_slopes[1] * slopes.take(at.row + 1, axis=0)
        return found

    def _weights(self, dead_s: float) -> _Between:
        t_s, row, share = self._t_s, np.arange(len(self._t_s)), np.zeros(len(self._t_s))
        for part in self._stretches:
            own_s = t_s[part]
            then_s = np.clip(own_s + dead_s, own_s[0], own_s[-1])
            own = np.clip(np.searchsorted(own_s, then_s, side="right") - 1, 0, len(own_s) - 2)
            row[part] = part.start + own
            share[part] = (then_s - own_s[own]) / (own_s[own + 1] - own_s[own])
        row = np.minimum(row, len(t_s) - 2)
        width_s, back = (t_s[row + 1] - t_s[row])[:, None], 1.0 - share[:, None]
        on = share[:, None]
        return _Between(
            row,
            (back**2 * (1.0 + 2.0 * on), on**2 * (1.0 + 2.0 * back)),
            (width_s * on * back**2, -width_s * on**2 * back),
        )
