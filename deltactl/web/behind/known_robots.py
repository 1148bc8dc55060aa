"""The robot as the page draws it: geometry, limits, and where the sensors say the platform is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np

from deltactl.firmware_py.controller.contract import SensorStatus
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import home_counts
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import ConfigError, DeltactlError, MissingFile
from deltactl.models.linkage import Linkage, inverse
from deltactl.models.linkage.scalar import counted_pose, forward_one
from deltactl.models.linkage.vectors import Vector

HALVINGS = 12
EDGE = 36
"""Directions in which the edge of the work area is looked for."""
BELOW_M = 0.02
"""The floor is drawn so far below the lowest point of the platform."""


@dataclass(frozen=True, slots=True)
class WorkArea:
    """Points [m] around what can be reached at one height, and the height of the floor [m]."""

    edge_m: tuple[Vector, ...]
    floor_m: float


@dataclass(frozen=True)
class KnownRobot:
    """A robot file that the page knows, by which name jobs ask for it, and its linkage."""

    file: str
    robot: RobotFile
    linkage: Linkage

    @classmethod
    def of(cls, path: Path) -> KnownRobot:
        """Read a robot file. Raises MissingFile or ConfigError."""
        robot = load_robot(path)
        return cls(path.name, robot, Linkage.of(robot.geometry))

    def pose(self, counts: tuple[int, ...]) -> tuple[Vector, Vector | None]:
        """Arm angles [rad] and platform position [m] of step counts."""
        forward = partial(forward_one, self.linkage)
        return counted_pose(counts, self.robot.drive.rad_per_step, forward)

    def measured(self, sensors: tuple[SensorStatus, ...]) -> Vector | None:
        """Where three good ranges put the platform [m]: range = offset + axis . p."""
        described = self.robot.sensors
        if described is None or len(sensors) != 3:
            return None
        rows, values = [], []
        for sensor in sensors:
            its = getattr(described, sensor.axis)
            if sensor.distance_m is None or sensor.gate != "good":
                return None
            rows.append(its.axis)
            values.append(sensor.distance_m - its.offset_m)
        try:
            x_m, y_m, z_m = np.linalg.solve(np.array(rows), np.array(values)).tolist()
        except np.linalg.LinAlgError:
            return None
        return x_m, y_m, z_m

    def allows(self, position_m: Vector) -> bool:
        """Whether the platform may be there: reachable, arms and box within their limits."""
        return not self.limit_at(position_m)

    def limit_at(self, position_m: Vector) -> str:
        """Which limit keeps the platform from a point, in words; empty where it may be."""
        found = inverse(self.linkage, np.array(position_m))
        angles_deg = np.degrees(found.angles_rad).tolist()
        if not np.isfinite(angles_deg).all() or int(found.status) != 0:
            return "the arms do not reach there"
        box = self.robot.limits.box_m or ((-math.inf, math.inf),) * 3
        for axis, at_m, (least_m, most_m) in zip("xyz", position_m, box, strict=True):
            if not least_m <= at_m <= most_m:
                return f"{axis} may be {1e3 * least_m:g} to {1e3 * most_m:g} mm (limits.box_m)"
        low, high = self.robot.limits.arm_deg
        for arm, angle_deg in enumerate(angles_deg, start=1):
            if not low <= angle_deg <= high:
                return f"arm {arm} may turn from {low:g} to {high:g} degrees (limits.arm_deg)"
        return ""

    @property
    def home_m(self) -> Vector | None:
        """Where the platform is at home [m]."""
        return self.pose(home_counts(self.robot))[1]

    def held(self, start_m: Vector, wanted_m: Vector) -> Vector:
        """The point nearest to `wanted_m`, on the line from `start_m`, that is allowed."""
        if self.allows(wanted_m):
            return wanted_m
        good, bad = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (good + bad)
            if self.allows(_between(start_m, wanted_m, middle)):
                good = middle
            else:
                bad = middle
        return _between(start_m, wanted_m, good)

    @cached_property
    def work_area(self) -> WorkArea | None:
        """How far the platform may go halfway down from home; None without a home."""
        home_m = self.home_m
        if home_m is None or not self.allows(home_m):
            return None
        far_m = 2.0 * float(np.max(self.linkage.upper_arm_m) + np.max(self.linkage.forearm_m))
        lowest_m = self.held(home_m, (home_m[0], home_m[1], home_m[2] - far_m))
        middle_m = _between(home_m, lowest_m, 0.5)
        edge = []
        for part in np.linspace(0.0, 2.0 * math.pi, EDGE, endpoint=False).tolist():
            x_m, y_m = far_m * math.cos(part), far_m * math.sin(part)
            edge.append(self.held(middle_m, (middle_m[0] + x_m, middle_m[1] + y_m, middle_m[2])))
        return WorkArea(tuple(edge), lowest_m[2] - BELOW_M)

    def held_angle(self, angle_deg: float) -> float:
        """An arm angle within its limits."""
        low, high = self.robot.limits.arm_deg
        return min(max(angle_deg, low), high)


def _between(start: Vector, end: Vector, part: float) -> Vector:
    x, y, z = (a + part * (b - a) for a, b in zip(start, end, strict=True))
    return x, y, z


class KnownRobots:
    """Finds the robot file of the robot that the daemon names."""

    def __init__(self, given: Path | None = None):
        self._given = given
        self._known: dict[str, KnownRobot | None] = {}

    @property
    def given(self) -> Path | None:
        """The robot file that the page was started with."""
        return self._given

    def of(self, name: str) -> KnownRobot | None:
        """The robot file whose `name` this is; None when the page has none."""
        if name not in self._known:
            self._known[name] = self._sought(name)
        return self._known[name]

    def _sought(self, name: str) -> KnownRobot | None:
        given = [self._given] if self._given is not None else []
        for path in (*given, *sorted(CONFIG_FOLDER.glob("*.yaml"))):
            try:
                known = KnownRobot.of(path)
            except (ConfigError, MissingFile, DeltactlError):
                continue  # a job, or a robot that cannot be run
            if known.robot.name == name:
                _ = known.work_area  # takes a moment, which no page is to wait for
                return known
        return None
