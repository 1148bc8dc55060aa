"""A robot without any effects, one sample at a time in plain floats."""

from __future__ import annotations

import math

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.linkage import Linkage
from deltactl.models.linkage.scalar_forward import forward_one
from deltactl.models.linkage.vectors import Vector
from deltactl.models.robot import ARMS


class NominalRobot:
    """What models/chain gives without effects, of counts: position, arm angles, and ranges, which
    are NaN without sensors."""

    def __init__(self, robot: RobotFile):
        self._linkage = Linkage.of(robot.geometry)
        self._step_rad = robot.drive.rad_per_step
        sensors = robot.sensors
        self._rows = [(math.nan, 0.0, 0.0, 0.0)] * ARMS
        if sensors is not None:
            rows = zip(sensors.offsets_m.tolist(), sensors.axes.tolist(), strict=True)
            self._rows = [(offset, *axis) for offset, axis in rows]
        self._at: Vector | None = None

    def at(self, steps: Vector) -> tuple[Vector, Vector, Vector]:
        """Platform [m], true arm angles [rad] and ranges [m] at commanded counts."""
        if steps != self._at:  # the arms stand still most of the time
            self._at, self._found = steps, self._find(steps)
        return self._found

    def _find(self, steps: Vector) -> tuple[Vector, Vector, Vector]:
        first, second, third = (count * self._step_rad for count in steps)
        x, y, z = position_m = forward_one(self._linkage, (first, second, third))
        ranges = [offset + a * x + b * y + c * z for offset, a, b, c in self._rows]
        return position_m, (first, second, third), (ranges[0], ranges[1], ranges[2])
