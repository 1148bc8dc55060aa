"""Where the parts of the robot are in space: pure geometry, no page."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from models.linkage import Linkage
from models.robot import FloatArray, Geometry

Matrix = list[list[float]]
ROD_APART_PART = 0.45
"""Of the platform's radius: half the distance between the two rods of a forearm."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A link: its middle [m], and a rotation whose second column points along it."""

    middle_m: tuple[float, float, float]
    rotation: Matrix


@dataclass(frozen=True, slots=True)
class Skeleton:
    """What does not change: radii [m], lengths [m], and the directions of the arms."""

    base_radius_m: float
    platform_radius_m: float
    upper_arm_m: tuple[float, ...]
    forearm_m: tuple[float, ...]
    outward: FloatArray
    """Unit vectors away from the axis, shape (3, 3), one row an arm."""

    @classmethod
    def of(cls, geometry: Geometry) -> Skeleton:
        """Of a robot file's geometry."""
        linkage = Linkage.of(geometry)
        azimuth = linkage.azimuth_rad
        outward = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(3)], axis=1)
        platform = float(np.max(geometry.platform_radius_m))
        return cls(
            base_radius_m=float(np.max(linkage.radius_m)) + platform,
            platform_radius_m=platform,
            upper_arm_m=tuple(linkage.upper_arm_m.tolist()),
            forearm_m=tuple(linkage.forearm_m.tolist()),
            outward=outward,
        )

    @property
    def rod_offset_m(self) -> float:
        """Half the distance between the rods of a forearm."""
        return ROD_APART_PART * self.platform_radius_m

    def shoulders_m(self) -> FloatArray:
        """Axes of the motors, shape (3, 3)."""
        shoulders: FloatArray = self.base_radius_m * self.outward
        return shoulders

    def elbows_m(self, angles_rad: tuple[float, ...]) -> FloatArray:
        """Ends of the upper arms, shape (3, 3)."""
        angles = np.array(angles_rad)[:, None]
        down = np.array([0.0, 0.0, -1.0])
        lengths = np.array(self.upper_arm_m)[:, None]
        arms: FloatArray = lengths * (np.cos(angles) * self.outward + np.sin(angles) * down)
        return self.shoulders_m() + arms

    def links(
        self, angles_rad: tuple[float, ...], position_m: tuple[float, float, float] | None
    ) -> list[Placed]:
        """Three upper arms, then three forearms (left out without a position)."""
        shoulders, elbows = self.shoulders_m(), self.elbows_m(angles_rad)
        ends = [(shoulders[k], elbows[k], k) for k in range(3)]
        if position_m is not None:
            wrists = np.array(position_m) + self.platform_radius_m * self.outward
            ends += [(elbows[k], wrists[k], k) for k in range(3)]
        return [self._placed(start, end, arm) for start, end, arm in ends]

    def _placed(self, start: FloatArray, end: FloatArray, arm: int) -> Placed:
        along = (end - start) / np.linalg.norm(end - start)
        level = np.cross([0.0, 0.0, 1.0], self.outward[arm])
        level = level - along * (level @ along)
        sideways = level / np.linalg.norm(level)
        rotation = np.stack([sideways, along, np.cross(sideways, along)], axis=1)
        x_m, y_m, z_m = (0.5 * (start + end)).tolist()
        return Placed((x_m, y_m, z_m), np.round(rotation, 5).tolist())


def quaternion(rotation: FloatArray) -> tuple[float, float, float, float]:
    """Quaternion x, y, z, w of a rotation matrix (Shepperd 1978: by the largest part)."""
    r = rotation
    parts = np.array([
        1.0 + r[0, 0] - r[1, 1] - r[2, 2], 1.0 - r[0, 0] + r[1, 1] - r[2, 2],
        1.0 - r[0, 0] - r[1, 1] + r[2, 2], 1.0 + r[0, 0] + r[1, 1] + r[2, 2],
    ])  # fmt: skip
    big = int(np.argmax(parts))
    rows = {
        0: (parts[0], r[1, 0] + r[0, 1], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]),
        1: (r[1, 0] + r[0, 1], parts[1], r[2, 1] + r[1, 2], r[0, 2] - r[2, 0]),
        2: (r[0, 2] + r[2, 0], r[2, 1] + r[1, 2], parts[2], r[1, 0] - r[0, 1]),
        3: (r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], parts[3]),
    }[big]
    x, y, z, w = (float(part) / (2.0 * math.sqrt(parts[big])) for part in rows)
    return x, y, z, w


def turn_x_to(axis: FloatArray) -> tuple[float, float, float, float]:
    """Quaternion of a turn that brings the x axis into a unit vector."""
    other = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    y = np.cross(other, axis)
    y = y / np.linalg.norm(y)
    return quaternion(np.stack([axis, y, np.cross(axis, y)], axis=1))
