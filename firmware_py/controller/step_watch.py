"""Sees lost steps while the robot runs: compares where the sensors say it is with the counts.

Of every good range the one expected from the edges really sent is taken off. What is left is
the model's error, which changes slowly, the sensors' noise, and steps that were lost. So the
median over the last `NOW_S` is compared with the median over some seconds before, and the
difference, through the linkage's derivatives, becomes steps of each motor.

Limits: what is lost slower than the window before is long is left to the diagnosis, and so is
a disagreement that was there from the start. With one sensor missing nothing is seen.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from drivers.ranging.contract import Gate, Reading
from drivers.steps.contract import Counts, Ticks
from firmware_py.robot_file import RobotFile
from foundation.clock import ns
from models.linkage import Linkage, forward
from models.robot import AXES, FloatArray

NOW_S = 0.4
BEFORE_S = (0.7, 3.0)
"""The window compared with, from so long ago to so long ago."""
LOOK_S = 0.1
READINGS_NEEDED = 6
LOOKS_IN_A_ROW = 2
LOSS_M = 0.008
"""Of an elbow's way: less is not told from play, the sensors' scale and latency, and noise."""
USUAL, USUAL_S = 4.0, 20.0
"""Nor is less than so many times what has been usual over the last so many seconds."""
NUDGE_RAD = 1e-4


@dataclass(frozen=True, slots=True)
class StepLoss:
    """Steps of one motor (1 to 3) that were sent but not made (negative: made but not sent)."""

    motor: int
    steps: int
    elbow_m: float

    def says(self) -> str:
        """One line."""
        return (
            f"lost steps: the sensors see motor{self.motor} about {abs(self.steps)} steps"
            f" ({abs(self.elbow_m) * 1e3:.0f} mm at the elbow)"
            f" {'behind' if self.steps > 0 else 'ahead of'} its counts"
        )


@dataclass(frozen=True, slots=True)
class _Residual:
    t_ns: int
    axis: int
    excess_m: float
    slope_m: FloatArray
    """Change of this range with a radian of each arm; shape (3,)."""


class StepWatch:
    """Fed with edges and readings (the latter from any thread); `look` judges now and then."""

    def __init__(self, robot: RobotFile):
        self._linkage = Linkage.of(robot.geometry)
        self._step_rad = robot.drive.rad_per_step
        self._elbows_m = np.broadcast_to(np.asarray(robot.geometry.upper_arm_m), (3,))
        self._sensors = robot.sensors
        self._readings: deque[Reading] = deque(maxlen=1000)
        self.reset((0, 0, 0), 0)

    def reset(self, counts: Counts, now_ns: int) -> None:
        """Begin afresh: the motors are where the counters say."""
        self._counts = np.array(counts, dtype=np.int64)
        self._times_ns = np.array([now_ns], dtype=np.int64)
        self._history = self._counts[np.newaxis, :]
        self._residuals: deque[_Residual] = deque()
        self._looked_ns = now_ns
        self._suspected = 0
        self._usual_m2 = 0.0
        self._readings.clear()

    def forgive(self) -> None:
        """Take what was found as given from now on."""
        self._residuals.clear()
        self._suspected = 0

    def sent(self, ticks: Ticks) -> None:
        """Edges really sent."""
        if len(ticks):
            counts = self._counts + np.cumsum(ticks.steps, axis=0, dtype=np.int64)
            self._times_ns = np.concatenate([self._times_ns, ticks.due_ns])
            self._history = np.vstack([self._history, counts])
            self._counts = counts[-1]

    def reading(self, reading: Reading) -> None:
        """A sample of a sensor."""
        if reading.gate is Gate.GOOD:
            self._readings.append(reading)

    def look(self, now_ns: int) -> StepLoss | None:
        """What is found, at most every `LOOK_S`; all edges up to `now_ns` must have been told."""
        if self._sensors is None or now_ns - self._looked_ns < ns(LOOK_S):
            return None
        self._looked_ns = now_ns
        self._take_readings()
        self._forget(now_ns)
        loss = self._compare(now_ns)
        self._suspected = self._suspected + 1 if loss else 0
        return loss if self._suspected >= LOOKS_IN_A_ROW else None

    def _take_readings(self) -> None:
        readings = [self._readings.popleft() for _ in range(len(self._readings))]
        if not readings:
            return
        assert self._sensors is not None
        times_ns = np.array([one.t_ns for one in readings])
        rows = np.searchsorted(self._times_ns, times_ns, side="right") - 1
        angles_rad = self._history[np.maximum(rows, 0)] * self._step_rad
        nudged = angles_rad[:, np.newaxis, :] + NUDGE_RAD * np.vstack([np.zeros(3), np.eye(3)])
        positions_m = forward(self._linkage, nudged).position_m
        axes = [AXES.index(one.axis) for one in readings]
        ranges_m = np.einsum("nki,ni->nk", positions_m, self._sensors.axes[axes])
        slopes_m = (ranges_m[:, 1:] - ranges_m[:, :1]) / NUDGE_RAD
        measured_m = np.array([one.distance_m for one in readings])
        excess_m = measured_m - self._sensors.offsets_m[axes] - ranges_m[:, 0]
        for t_ns, axis, excess, slope in zip(
            times_ns.tolist(), axes, excess_m.tolist(), slopes_m, strict=True
        ):
            if np.isfinite(excess) and np.all(np.isfinite(slope)):
                self._residuals.append(_Residual(t_ns, axis, excess, slope))

    def _forget(self, now_ns: int) -> None:
        oldest_ns = now_ns - ns(BEFORE_S[1])
        while self._residuals and self._residuals[0].t_ns < oldest_ns:
            self._residuals.popleft()
        keep = max(0, int(np.searchsorted(self._times_ns, now_ns - ns(1.0))) - 1)
        self._times_ns, self._history = self._times_ns[keep:], self._history[keep:]

    def _compare(self, now_ns: int) -> StepLoss | None:
        newest = [one for one in self._residuals if one.t_ns >= now_ns - ns(NOW_S)]
        before = [one for one in self._residuals if one.t_ns < now_ns - ns(BEFORE_S[0])]
        change_m, slopes_m = np.empty(3), np.empty((3, 3))
        for axis in range(3):
            now_m = [one.excess_m for one in newest if one.axis == axis]
            before_m = [one.excess_m for one in before if one.axis == axis]
            if min(len(now_m), len(before_m)) < READINGS_NEEDED:
                return None
            change_m[axis] = np.median(now_m) - np.median(before_m)
            slopes_m[axis] = np.mean([o.slope_m for o in newest if o.axis == axis], axis=0)
        try:
            moved_rad = np.linalg.solve(slopes_m, change_m)
        except np.linalg.LinAlgError:
            return None
        worst = int(np.argmax(np.abs(moved_rad)))
        elbow_m = float(moved_rad[worst] * self._elbows_m[worst])
        if abs(elbow_m) < max(LOSS_M, USUAL * self._usual_m2**0.5):
            self._usual_m2 += LOOK_S / USUAL_S * (elbow_m**2 - self._usual_m2)
            return None
        behind = -float(moved_rad[worst]) / self._step_rad
        return StepLoss(worst + 1, round(behind), elbow_m)
