"""What a drive makes of the effort that is asked of it: it comes late, and reaches its limit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.lone.options import LONE
from deltactl.diagnosis.plants.regressor import Size
from deltactl.foundation.scatter import MAD_TO_SIGMA


def late_sizes(spread_s: float, period_s: float) -> tuple[Size, ...]:
    """Time constant and dead time of a drive, each shorter than any that something follows."""
    longest_s, names = LONE.longest_lag_s, ("time", "dead_time")
    ends, within = (0.0, longest_s), (-np.inf, longest_s)
    return tuple(Size(n, "half", spread_s, *ends, 0.05 * period_s, within=within) for n in names)


@dataclass(eq=False)
class EffortLimit:
    """The largest effort that a drive gives, seen in a low-passed effort (n,) as it was asked for.

    needed: force (n,) that the motion needs by the robot file. observed: what that leaves, (n,).
    shapes: of all named forces together, (n, k).
    """

    force: FloatArray
    needed: FloatArray
    rows: IntArray
    observed: FloatArray
    shapes: FloatArray

    @property
    def differs(self) -> dict[str, Any]:
        """What its regressor is: between the effort that is usually asked for and the largest."""
        asked = np.abs(self.force[self.rows])
        # A drive that could not give half of what is asked of it would follow nothing.
        peak, low = max(float(asked.max()), 1e-300), float(np.median(asked))
        reached = (self._excursion, peak - self._excursion)
        size = Size("limit", "flat", peak, low, peak, 2e-3 * peak, within=reached)
        starts = tuple((low + share * (peak - low),) for share in LONE.limit_starts)
        return {"sizes": (size,), "starts": starts, "saturated": False}

    def kept_back(self, limit: float) -> FloatArray:
        """Effort (n,) beyond a limit, where it is more than noise makes of an effort at it."""
        beyond = np.abs(self.force) - limit
        return np.asarray(np.sign(self.force) * np.where(beyond > self._excursion, beyond, 0.0))

    @cached_property
    def _excursion(self) -> float:
        """How far readings are off where little is needed and no limit reached: the farthest one,
        and that of as many of a normal distribution.
        """
        needed = np.abs(self.needed[self.rows])
        rows = self.rows[needed <= np.median(needed)]
        shapes, force = self.shapes[rows], self.observed[rows]
        left = np.abs(force - shapes @ np.linalg.lstsq(shapes, force, rcond=1e-10)[0])
        expected = MAD_TO_SIGMA * float(np.median(left)) * np.sqrt(2.0 * np.log(len(self.rows)))
        return max(float(expected), float(left.max()))
