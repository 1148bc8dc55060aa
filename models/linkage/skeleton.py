"""Where the parts of the robot are in space: pure geometry, no page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.models.linkage import Linkage
from deltactl.models.linkage.vectors import Vector, cross, dot, less, times, unit
from deltactl.models.robot import FloatArray, Geometry

Matrix = list[list[float]]
ROD_APART_PART = 0.45
"""Share of the platform's radius: half the distance between the two rods of a forearm."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A link: its middle [m], and a rotation whose second column points along it."""

    middle_m: Vector
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
        """Skeleton of a robot file's geometry."""
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

    def links(self, angles_rad: tuple[float, ...], position_m: Vector | None) -> list[Placed]:
        """Three upper arms, then three forearms (left out without a position).

        In plain floats: it is asked for ten times a second beside a running motion.
        """
        arms, rods = [], []
        for number, (east, north, _) in enumerate(self.outward.tolist()):
            shoulder = (self.base_radius_m * east, self.base_radius_m * north, 0.0)
            length_m, angle_rad = self.upper_arm_m[number], angles_rad[number]
            reach_m = self.base_radius_m + length_m * math.cos(angle_rad)
            elbow = (reach_m * east, reach_m * north, -length_m * math.sin(angle_rad))
            level = (-north, east, 0.0)
            arms.append(placed(shoulder, elbow, level))
            if position_m is not None:
                x_m, y_m, z_m = position_m
                aside_m = self.platform_radius_m
                wrist = (x_m + aside_m * east, y_m + aside_m * north, z_m)
                rods.append(placed(elbow, wrist, level))
        return arms + rods


def placed(start: Vector, end: Vector, level: Vector) -> Placed:
    """A link from here to there [m]; `level`, a unit vector, is not along it: its motor's axis."""
    along = unit(less(end, start))
    sideways = unit(less(level, times(along, dot(level, along))))
    columns = zip(sideways, along, cross(sideways, along), strict=True)
    rotation = [[round(value, 5) for value in row] for row in columns]
    x_m, y_m, z_m = (0.5 * (a + b) for a, b in zip(start, end, strict=True))
    return Placed((x_m, y_m, z_m), rotation)


def quaternion(rotation: Sequence[Sequence[float]]) -> tuple[float, float, float, float]:
    """Quaternion x, y, z, w of a rotation matrix (Shepperd 1978: by the largest part)."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    parts = (1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz, 1.0 + xx + yy + zz)
    big = max(range(4), key=parts.__getitem__)
    found = (
        (parts[0], yx + xy, xz + zx, zy - yz),
        (yx + xy, parts[1], zy + yz, xz - zx),
        (xz + zx, zy + yz, parts[2], yx - xy),
        (zy - yz, xz - zx, yx - xy, parts[3]),
    )[big]
    x, y, z, w = (part / (2.0 * math.sqrt(parts[big])) for part in found)
    return x, y, z, w


def turn_x_to(axis: FloatArray) -> tuple[float, float, float, float]:
    """Quaternion of a turn that brings the x axis into a unit vector."""
    other = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    y = np.cross(other, axis)
    y = y / np.linalg.norm(y)
    return quaternion(np.stack([axis, y, np.cross(axis, y)], axis=1).tolist())
