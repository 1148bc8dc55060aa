"""What unlimited data from the same sensors would give: the limit of every model that trusts them.

A model that learns counts from measured positions can at best learn the exact inverse of the
expected measured map: noise averaged away, friction at the middle of its band, but offsets, scale
and cross talk of the sensors copied. What is left of its tracking error is the limit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.robot import FloatArray, Sensors
from deltactl.models.training.dataset import IntArray
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.run import Truth
from deltactl.proof.sensors.ranging import ideal_ranges
from deltactl.reproduction.zhao_2023.settling import SettlingRobot

ROUNDS = 8
CLOSE_M = 2e-5
"""A fifth of what one microstep moves."""
PROBE_STEPS = 40


@dataclass
class ExpectedMap:
    """Counts to expected measured position, in both directions."""

    machine: Machine
    sensors: Sensors

    def __post_init__(self) -> None:
        joints = replace(self.machine.robot.joints, friction_nm=np.full(3, 1e-6))
        self._robot = replace(self.machine.robot, joints=joints)

    def measured_m(self, position_m: FloatArray) -> FloatArray:
        """What the sensors say on average of platforms at rest (n, 3) [m], same shape."""
        apart_s = 1e6 * np.arange(len(position_m), dtype=np.float64)
        still = Truth(apart_s, position_m, np.zeros_like(position_m), 0.0)
        if len(position_m) == 1:
            still = Truth(np.array([0.0, 1e6]), np.repeat(position_m, 2, 0), np.zeros((2, 3)), 0.0)
        ranges_m = ideal_ranges(self.machine.sensors, still, apart_s)
        measured: FloatArray = np.linalg.solve(
            self.sensors.axes, (ranges_m - self.sensors.offsets_m).T
        ).T
        return measured

    def counts_of(self, target_m: FloatArray, start: IntArray) -> IntArray:
        """Counts (n, 3) at which the targets would be measured, one after another.

        start: counts (3,) not far from the first. Raises UnreachablePoint.
        """
        robot = SettlingRobot(self._robot, start)
        counts = start.astype(np.float64)
        slope = self._slope(robot, counts)
        found = np.empty(target_m.shape, dtype=np.int64)
        for row, target in enumerate(target_m):
            for attempt in range(ROUNDS):
                missing = target - self._at(robot, counts)
                if np.abs(missing).max() < CLOSE_M:
                    break
                if attempt:
                    slope = self._slope(robot, counts)
                counts = counts + np.linalg.solve(slope, missing)
            else:
                at = ", ".join(f"{value:.4f}" for value in target)
                raise UnreachablePoint(f"({at}) m is not measured at any counts")
            found[row] = np.rint(counts)
        return found

    def _at(self, robot: SettlingRobot, counts: FloatArray) -> FloatArray:
        # Between two whole steps nothing is lost: a motor is carried there all the same.
        here: FloatArray = self.measured_m(robot.move(counts)[None])[0]
        return here

    def _slope(self, robot: SettlingRobot, counts: FloatArray) -> FloatArray:
        columns = []
        for motor in range(3):
            step = np.zeros(3)
            step[motor] = PROBE_STEPS
            ahead, behind = self._at(robot, counts + step), self._at(robot, counts - step)
            columns.append((ahead - behind) / (2.0 * PROBE_STEPS))
        self._at(robot, counts)
        return np.stack(columns, axis=1)
