"""Laps of a robot that remembers: what is commanded on them differs from what was mapped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from deltactl.firmware_py.compensation.remembering import Course, Remembering
from deltactl.firmware_py.planner.plan import TimedLap
from deltactl.firmware_py.planner.targets import Lap
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.robot import FloatArray

USUAL_START_S = 3.0
"""From switching the drives on to the start of a path, for what changes as the arms warm up."""


class LapMemory:
    """Commands the first and every later lap of one plan."""

    def __init__(self, robot: RobotFile, remembering: Remembering):
        self._remembering = remembering
        self._step_rad = robot.drive.rad_per_step
        self._first_rad: FloatArray | None = None
        """Mapped angles of the first lap."""
        self._again_rad: FloatArray | None = None

    def first(self, timed: TimedLap) -> Lap:
        """The first lap; the way to it takes play up in the direction it will set out in."""
        if self._first_rad is None:
            self._first_rad = timed.lap.angles_rad
        mapped = Course(_times_s(timed), self._first_rad)
        before = self._remembering.before(mapped)
        return self._commanded(timed.lap, self._remembering.angles_rad(mapped, before))

    def again(self, timed: TimedLap, first: TimedLap) -> Lap:
        """Every later lap: it begins where the one before ended, and ends there too.

        Growth is followed up to the second lap; what little is left of it later is not.
        """
        if self._again_rad is None:
            self._again_rad = timed.lap.angles_rad
        earlier = Course(_times_s(first), first.lap.angles_rad)
        begins_s = float(earlier.t_s[-1]) + float(first.lap.dwell_s[-1])
        mapped = Course(begins_s + _times_s(timed) - USUAL_START_S, self._again_rad)
        commanded = self._remembering.angles_rad(mapped, earlier)
        commanded[0] = commanded[-1] = first.lap.angles_rad[-1]
        return self._commanded(timed.lap, commanded)

    def preload_rad(self) -> FloatArray | None:
        """How far before the start of the path the way to it begins, (3,) [rad].

        As the arms are meant to set out, which is what the first lap was worked out for: where an
        arm turns round within a step of the start, what is commanded may set out the other way.
        """
        if self._first_rad is None:
            return None
        preload = self._remembering.preload_rad(self._first_rad)
        return preload if preload.any() else None

    def _commanded(self, lap: Lap, angles_rad: FloatArray) -> Lap:
        counts = np.rint(angles_rad / self._step_rad).astype(np.int64)
        return replace(lap, angles_rad=angles_rad, counts=counts, mapped=lap.mapped_counts)


def _times_s(timed: TimedLap) -> FloatArray:
    times: FloatArray = USUAL_START_S + timed.schedule.reached_ns / NS_PER_S
    return times
