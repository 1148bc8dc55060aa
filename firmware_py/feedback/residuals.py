"""What good ranges say beyond what the edges really sent explain: the watch's raw material."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.drivers.ranging.contract import Reading
from deltactl.drivers.steps.contract import Counts, Ticks
from deltactl.firmware_py.compensation.lead import accepted_lags_s
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S, ns
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.chain.active import at, of_entries
from deltactl.models.effects import Trait, has
from deltactl.models.effects.kind import Port, scalar
from deltactl.models.robot import AXES, FloatArray

Int64Array = np.ndarray[Any, np.dtype[np.int64]]
EDGES_KEPT_NS = 1_000_000_000
"""A reading comes a timing budget and a poll after its light."""
NUDGE_RAD = 1e-4
LAGS, MOST_KEPT_S = 8.0, 4.0
"""So many lags after a step a drive has made it, and longer than this none is waited for."""
RATE_S = 0.15
"""Speeds are averages over this long before a reading, as late ones see them."""


@dataclass(frozen=True, slots=True)
class Residuals:
    """Rows in the order they came.

    t_ns, axis: (n,). excess_m: (n,), measured less expected. slope_m: (n, 3), change of that
    range with a radian of each arm. rate_mps: (n,), how fast the range was meant to change.
    """

    t_ns: Int64Array
    axis: Int64Array
    excess_m: FloatArray
    slope_m: FloatArray
    rate_mps: FloatArray

    @classmethod
    def none(cls) -> Residuals:
        """No rows."""
        whole = np.zeros(0, dtype=np.int64)
        return cls(whole, whole, np.zeros(0), np.zeros((0, 3)), np.zeros(0))

    def since(self, t_ns: int) -> Residuals:
        """Rows from about this time on: all that came after the first such row."""
        start = int(np.argmax(self.t_ns >= t_ns)) if len(self.t_ns) else 0
        if len(self.t_ns) and self.t_ns[start] < t_ns:
            return self.none()
        return Residuals(
            self.t_ns[start:],
            self.axis[start:],
            self.excess_m[start:],
            self.slope_m[start:],
            self.rate_mps[start:],
        )

    def and_then(self, more: Residuals) -> Residuals:
        """These rows, then others."""
        return Residuals(
            np.concatenate([self.t_ns, more.t_ns]),
            np.concatenate([self.axis, more.axis]),
            np.concatenate([self.excess_m, more.excess_m]),
            np.vstack([self.slope_m, more.slope_m]),
            np.concatenate([self.rate_mps, more.rate_mps]),
        )


def _readings_late_s(robot: RobotFile) -> float:
    """By how much all readings are late, as the robot file says [s]."""
    clock = at(of_entries(robot.effects), Port.CLOCK)
    return sum(scalar(one.values, "time") for one in clock if has(one.kind.name, Trait.DELAY))


class Expectation:
    """Knows the edges sent, and so where the arms should be when a sample was taken."""

    def __init__(self, robot: RobotFile):
        self._calibrated = CalibratedInverse(robot)
        self._step_rad = robot.drive.rad_per_step
        self._sensors = robot.sensors
        self._dead_s, self._lag_s = accepted_lags_s(robot)
        late_s = float((self._dead_s + np.minimum(LAGS * self._lag_s, MOST_KEPT_S)).max())
        self._read_late_ns = ns(_readings_late_s(robot))
        self._kept_ns = EDGES_KEPT_NS + ns(late_s) + self._read_late_ns
        self.reset((0, 0, 0), 0)

    def reset(self, counts: Counts, now_ns: int) -> None:
        """The motors are where the counters say."""
        self._times_ns: Int64Array = np.array([now_ns], dtype=np.int64)
        self._counts: Int64Array = np.array([counts], dtype=np.int64)
        self._new: deque[Ticks] = deque()

    def sent(self, ticks: Ticks) -> None:
        """Edges really sent."""
        self._new.append(ticks)

    def forget(self, now_ns: int) -> None:
        """Drop edges that no reading can belong to any more."""
        self._take_edges()
        keep = max(0, int(np.searchsorted(self._times_ns, now_ns - self._kept_ns)) - 1)
        self._times_ns, self._counts = self._times_ns[keep:], self._counts[keep:]

    def residuals(self, readings: list[Reading]) -> Residuals:
        """What the readings say beyond the edges; those where the linkage jams are left out."""
        if self._sensors is None or not readings:
            return Residuals.none()
        self._take_edges()
        t_ns = np.array([reading.t_ns for reading in readings])
        counts = self._followed_at(t_ns)
        angles_rad = self._calibrated.achieved_rad(counts * self._step_rad)
        turned_rad = (counts - self._followed_at(t_ns - ns(RATE_S))) * self._step_rad
        nudged = angles_rad[:, np.newaxis, :] + NUDGE_RAD * np.vstack([np.zeros(3), np.eye(3)])
        positions_m = self._calibrated.place_m(nudged)
        axis = np.array([AXES.index(reading.axis) for reading in readings])
        ranges_m = np.einsum("nki,ni->nk", positions_m, self._sensors.axes[axis])
        slope_m = (ranges_m[:, 1:] - ranges_m[:, :1]) / NUDGE_RAD
        measured_m = np.array([reading.distance_m for reading in readings])
        excess_m = measured_m - self._sensors.offsets_m[axis] - ranges_m[:, 0]
        known = np.isfinite(excess_m) & np.isfinite(slope_m).all(axis=1)
        rate_mps = (slope_m * turned_rad).sum(axis=1) / RATE_S
        return Residuals(t_ns[known], axis[known], excess_m[known], slope_m[known], rate_mps[known])

    def excess_m(self, counts: Counts, ranges_m: FloatArray) -> FloatArray | None:
        """What ranges, (3,), say beyond arms that rest at these counts; None without sensors."""
        if self._sensors is None:
            return None
        commanded_rad = np.array([counts], dtype=np.float64) * self._step_rad
        expected_m = self._calibrated.position_m(commanded_rad)[0] @ self._sensors.axes.T
        excess_m: FloatArray = ranges_m - self._sensors.offsets_m - expected_m
        return excess_m

    def _followed_at(self, t_ns: Int64Array) -> FloatArray:
        """Counts (n, 3) that readings of these times show: drives and readings may be late."""
        t_ns = t_ns - self._read_late_ns
        counts = self._counts_at(t_ns).astype(np.float64)
        for motor in np.flatnonzero(self._dead_s + self._lag_s):
            seen_ns = t_ns - ns(float(self._dead_s[motor]))
            counts[:, motor] = self._counts_at(seen_ns)[:, motor]
            if self._lag_s[motor] > 0.0:
                counts[:, motor] -= self._unfollowed(int(motor), seen_ns)
        return counts

    def _unfollowed(self, motor: int, t_ns: Int64Array) -> FloatArray:
        """What a lag of the first order leaves of each step is exp(-age / lag): their sum, (n,)."""
        steps = np.diff(self._counts[:, motor])
        moves = np.flatnonzero(steps)
        ages_s = (t_ns[:, np.newaxis] - self._times_ns[moves + 1]) / NS_PER_S
        left = np.where(ages_s >= 0.0, np.exp(-np.maximum(ages_s, 0.0) / self._lag_s[motor]), 0.0)
        unfollowed: FloatArray = left @ steps[moves]
        return unfollowed

    def _counts_at(self, t_ns: Int64Array) -> Int64Array:
        rows = np.searchsorted(self._times_ns, t_ns, side="right") - 1
        counts: Int64Array = self._counts[np.maximum(rows, 0)]
        return counts

    def _take_edges(self) -> None:
        new = [self._new.popleft() for _ in range(len(self._new))]
        if not new:
            return
        steps = np.concatenate([ticks.steps for ticks in new])
        counts = self._counts[-1] + np.cumsum(steps, axis=0, dtype=np.int64)
        self._times_ns = np.concatenate([self._times_ns, *(ticks.due_ns for ticks in new)])
        self._counts = np.vstack([self._counts, counts])
