"""What the sensors see of arms that are not homed yet, while a switch is sought.

Where all three ranges are good they say where the arms are, roughly: to what their offsets are
wrong. From there on the steps sent say what the ranges should become, so that offsets cancel.
"""

from __future__ import annotations

import numpy as np

from deltactl.drivers.ranging.contract import Reading
from deltactl.drivers.steps.contract import Counts, Ticks
from deltactl.firmware_py.controller.sensing.cause import causes, in_words
from deltactl.firmware_py.controller.sensing.ranging_loop import RangingLoop
from deltactl.firmware_py.feedback.residuals import Expectation, Residuals
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import Clock, ns, sleep_s
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.robot import AXES, FloatArray

LOOK_S = 0.4
"""How long the sensors are listened to: some 20 rounds at 50 Hz."""
LEAST_READINGS, LEAST_LOOKS = 5, 8
"""A sensor that refuses most of its samples is not trusted for the rest."""
EVERY_S = 0.2
SCATTER_M = 0.001
"""Scatter of a median of the readings of `LOOK_S`, generously."""


def listen(robot: RobotFile, ranging: RangingLoop, clock: Clock) -> FloatArray:
    """Median of the good readings of each axis taken from now on [m]; NaN for too few."""
    period_s = 1.0 / robot.ranging.rate_hz
    since_ns = clock.now_ns()
    heard: dict[str, dict[int, float]] = {axis: {} for axis in AXES}
    until_ns = since_ns + ns(max(LOOK_S, LEAST_LOOKS * period_s))
    while clock.now_ns() < until_ns:
        sleep_s(clock, period_s)
        for reading in ranging.good_readings(since_ns):
            heard[reading.axis][reading.t_ns] = reading.distance_m
    enough = [list(one.values()) for one in heard.values()]
    return np.array([np.median(one) if len(one) >= LEAST_READINGS else np.nan for one in enough])


class OnTheWay:
    """Compares what the sensors see with the steps sent, from `begin` on."""

    def __init__(self, robot: RobotFile, ranging: RangingLoop, clock: Clock):
        self._robot = robot
        self._ranging = ranging
        self._clock = clock
        self._expected = Expectation(robot)
        self._base_rad: FloatArray | None = None
        self._counts = np.zeros(3, dtype=np.int64)
        self._rows = Residuals.none()
        self._new: dict[tuple[str, int], Reading] = {}
        self._since_ns = self._looked_ns = 0

    def begin(self) -> FloatArray | None:
        """Where the arms are seen [rad], (3,); None where the sensors do not show it.

        The arms must be at rest, and stay so until this returns (some 0.4 s).
        """
        self._base_rad = self._seen_rad()
        if self._base_rad is not None:
            steps = np.rint(self._base_rad / self._robot.drive.rad_per_step).astype(np.int64)
            first, second, third = steps.tolist()
            counts: Counts = (first, second, third)
            self._counts = steps
            self._expected.reset(counts, self._clock.now_ns())
        self._restart()
        return self._base_rad

    def sent(self, ticks: Ticks) -> None:
        """Steps that were pushed."""
        if self._base_rad is not None and len(ticks):
            self._expected.sent(ticks)
            self._counts = self._counts + ticks.steps.sum(axis=0, dtype=np.int64)

    def look(self) -> tuple[FloatArray | None, str]:
        """Where the arms are seen now [rad], or None; and what contradicts the steps, in words.

        Cheap: it works something out every `EVERY_S` only.
        """
        if self._base_rad is None:
            return None, ""
        for reading in self._ranging.good_readings(self._since_ns):
            self._new[reading.axis, reading.t_ns] = reading
        now_ns = self._clock.now_ns()
        if now_ns - self._looked_ns < ns(EVERY_S):
            return None, ""
        self._looked_ns = now_ns
        new, self._new = list(self._new.values()), {}
        self._since_ns = max((one.t_ns + 1 for one in new), default=self._since_ns)
        rows = self._rows.and_then(self._expected.residuals(new))
        self._rows = rows.since(now_ns - ns(LOOK_S))
        return self._compare()

    def _restart(self) -> None:
        self._rows, self._new = Residuals.none(), {}
        self._since_ns = self._looked_ns = self._clock.now_ns()

    def _compare(self) -> tuple[FloatArray | None, str]:
        rows, excess_m, slopes_m = self._rows, np.empty(3), np.empty((3, 3))
        for axis in range(3):
            mine = rows.axis == axis
            if mine.sum() < LEAST_READINGS:
                return None, ""
            excess_m[axis] = np.median(rows.excess_m[mine])
            slopes_m[axis] = rows.slope_m[mine].mean(axis=0)
        if np.linalg.cond(slopes_m) > 1e6:
            return None, ""
        moved_rad = np.linalg.solve(slopes_m, excess_m)
        seen_rad: FloatArray = self._counts * self._robot.drive.rad_per_step + moved_rad
        if np.abs(excess_m).max() <= self._robot.homing.warning_m:
            return seen_rad, ""
        due_rad = self._counts * self._robot.drive.rad_per_step
        found = causes(self._robot, due_rad, excess_m, np.full(3, SCATTER_M), slopes_m)
        return seen_rad, in_words(self._robot, found)

    def _seen_rad(self) -> FloatArray | None:
        sensors = self._robot.sensors
        if sensors is None:
            return None
        ranges_m = listen(self._robot, self._ranging, self._clock)
        if not np.isfinite(ranges_m).all():
            return None
        if np.linalg.matrix_rank(sensors.axes, tol=1e-3) < 3:
            return None
        position_m = np.linalg.solve(sensors.axes, ranges_m - sensors.offsets_m)
        seen_rad = CalibratedInverse(self._robot).angles_rad_at_once(position_m[np.newaxis])[0]
        return seen_rad if np.isfinite(seen_rad).all() else None
