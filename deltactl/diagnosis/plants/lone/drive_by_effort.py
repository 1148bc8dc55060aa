"""What a drive makes of the effort that is asked of it: it comes late, and reaches its limit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from deltactl.diagnosis.observations.ahead_in_time import AheadInTime, Curves
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.lone.options import LONE
from deltactl.diagnosis.plants.regression import Columns, Size
from deltactl.foundation.scatter import MAD_TO_SIGMA


class LateDrive:
    """Forces as an effort shows them whose motion comes late: ahead of the motion.

    The effort as read is left as it is. A lag that smoothed it would explain its noise.
    """

    def __init__(self, in_time: AheadInTime):
        self._in_time = in_time
        self._kept: dict[str, tuple[Columns, Curves, tuple[float, float], Columns]] = {}
        """Columns, their curves, what they are ahead by, and as they are then."""

    def led(self, key: str, columns: Columns, dead_s: float, time_s: float) -> Columns:
        """Columns of one regressor ahead by a dead time and a time constant; the last are kept."""
        at, kept = (dead_s, time_s), self._kept.get(key)
        if kept is None or kept[0] is not columns:
            curves = columns.curves() if columns.curves else self._in_time.curves(columns.values)
            kept = (columns, curves, (0.0, 0.0), columns)
        if kept[2] != at:
            led = replace(columns, values=self._in_time.later(kept[1], *at), curves=None)
            kept = (columns, kept[1], at, led)
        self._kept[key] = kept
        return kept[3]


class EffortLimit:
    """The largest effort that a drive gives, seen in a low-passed effort (n,) as it was asked for.

    left: absolute value (m,) of what all named forces together leave of some rows (m,). needed:
    force (n,) that the motion needs by the robot file.
    """

    def __init__(
        self,
        force: FloatArray,
        needed: FloatArray,
        rows: IntArray,
        left: Callable[[IntArray], FloatArray],
    ):
        self._force, self._needed, self._rows, self._left = force, needed, rows, left
        asked = np.abs(force[rows])
        self._peak = max(float(asked.max()), 1e-300)
        # A drive that could not give half of what is asked of it would follow nothing.
        self._usual = float(np.median(asked))

    @property
    def size(self) -> Size:
        """Between the effort that is usually asked for and the largest."""
        peak = self._peak
        return Size("limit", "flat", peak, self._usual, peak, 2e-3 * peak)

    @property
    def starts(self) -> list[float]:
        """Limits from which fits begin."""
        low, room = self._usual, self._peak - self._usual
        return [low + share * room for share in LONE.limit_starts]

    def kept_back(self, limit: float) -> FloatArray:
        """Effort (n,) beyond a limit, where it is more than noise makes of an effort at it."""
        beyond = np.abs(self._force) - limit
        beyond[beyond <= self._excursion] = 0.0
        found: FloatArray = np.sign(self._force) * beyond
        return found

    def is_reached(self, limit: float) -> bool:
        """Whether a limit is larger than what noise makes of no effort, and is reached."""
        reached = self.kept_back(limit)[self._rows].any()
        return limit >= self._excursion and bool(reached)

    @cached_property
    def _excursion(self) -> float:
        """How far readings are off where little is needed and no limit reached: the farthest one,
        and that of as many of a normal distribution.
        """
        needed = np.abs(self._needed[self._rows])
        left = self._left(self._rows[needed <= np.median(needed)])
        expected = MAD_TO_SIGMA * float(np.median(left)) * np.sqrt(2.0 * np.log(len(self._rows)))
        return max(float(expected), float(left.max()))
