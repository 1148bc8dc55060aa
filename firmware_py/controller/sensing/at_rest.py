"""Do the ranges still agree with the counts while the arms should be still? Two comparisons.

With the first second of this rest: offsets and wrong lengths cancel, so that an arm which sags
however slowly shows from `homing.warning_m` on. With what the sensors said at homing: so that
what crept in over many jobs, at another place, shows from `homing.tolerance_m` on, as it would
at homing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from deltactl.firmware_py.feedback.residuals import Residuals
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import ns
from deltactl.models.robot import FloatArray

NOW_S = 0.28
FIRST_S = 1.0
"""How much of a rest is taken for its beginning."""
READINGS_NEEDED = 6
PERIODS = 8
"""Sensors that range slowly are heard for so many periods."""
SCATTER_M = 0.0006
"""Scatter of a median of the readings of `NOW_S`: 1.5 mm of noise in 14 readings."""


class Off(NamedTuple):
    """What the ranges say beyond the counts, and how the arms would change them."""

    change_m: FloatArray
    scatter_m: FloatArray
    slopes_m: FloatArray


class AtRest:
    """Fed with rows of residuals; asked while the arms should be still."""

    def __init__(self, robot: RobotFile):
        self._tolerance_m = robot.homing.tolerance_m
        self._creep_m = min(robot.homing.warning_m, robot.homing.tolerance_m)
        self._look_ns = ns(max(NOW_S, PERIODS / robot.ranging.rate_hz))
        self._home_m: FloatArray | None = None
        self._first_m: FloatArray | None = None

    def homed(self, excess_m: FloatArray | None) -> None:
        """What the ranges say beyond the counts at home, (3,); None or NaN where unseen."""
        seen = excess_m is not None and bool(np.isfinite(excess_m).all())
        self._home_m = excess_m if seen else None
        self._first_m = None

    def moved(self) -> None:
        """The arms move: another rest begins."""
        self._first_m = None

    def off(self, rows: Residuals, since_ns: int, now_ns: int) -> Off | None:
        """What has become of a rest that began at `since_ns`, where that is too much."""
        now = _medians(rows, max(since_ns, now_ns - self._look_ns))
        if now is None:
            return None
        if self._first_m is not None and _larger(now.change_m - self._first_m, self._creep_m):
            return now._replace(change_m=now.change_m - self._first_m)
        if self._first_m is None and now_ns - since_ns >= ns(FIRST_S):
            first = _medians(rows, since_ns)
            self._first_m = None if first is None else first.change_m
        if self._home_m is not None and _larger(now.change_m - self._home_m, self._tolerance_m):
            return now._replace(change_m=now.change_m - self._home_m)
        return None


def _larger(change_m: FloatArray, limit_m: float) -> bool:
    return bool(np.abs(change_m).max() > limit_m)


def _medians(rows: Residuals, since_ns: int) -> Off | None:
    """Median of each axis; None where one has too few readings."""
    excess_m, slopes_m = np.empty(3), np.empty((3, 3))
    for axis in range(3):
        mine = (rows.axis == axis) & (rows.t_ns >= since_ns)
        if mine.sum() < READINGS_NEEDED:
            return None
        excess_m[axis] = np.median(rows.excess_m[mine])
        slopes_m[axis] = rows.slope_m[mine].mean(axis=0)
    return Off(excess_m, np.full(3, SCATTER_M), slopes_m)
