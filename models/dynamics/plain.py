"""The terms of a delta's equation of motion at one pose, in plain floats.

The same as `models.dynamics.terms`, which explains it, and gravity as `models.gravity`; a loop
that asks ten thousand times a second cannot afford arrays of three.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin, sqrt
from typing import NamedTuple

from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.gravity import STANDARD_GRAVITY_MPS2
from deltactl.models.linkage import Linkage
from deltactl.models.linkage.vectors import Vector, cross, dot, less, times
from deltactl.models.robot import Masses

LEAST_VOLUME = 1e-4
"""Volume of the forearms' directions below which the platform is as good as loose."""


class Terms(NamedTuple):
    """Mass matrix (its six different entries) [kg m2] and, for each arm, c + g [N m]."""

    m11: float
    m22: float
    m33: float
    m12: float
    m13: float
    m23: float
    load: Vector


class PlainBody:
    """A delta's moving parts. Angles are true ones: home offsets belong to who commands them."""

    def __init__(self, linkage: Linkage, masses: Masses, payload_kg: float = 0.0):
        self._arms = tuple(
            (arm.east, arm.north, arm.radius_m, arm.upper_arm_m, arm.upper_arm_m**2 / 3.0)
            for arm in linkage.plain.arms
        )
        self._forearms2 = tuple((linkage.forearm_m**2).tolist())
        self._least_m3 = LEAST_VOLUME * float(linkage.forearm_m.prod())
        rod_kg = masses.forearm_kg
        self._own_kg = masses.upper_arm_kg + rod_kg
        self._sixth_kg = rod_kg / 6.0
        self._hung_kg = masses.platform_kg + payload_kg + rod_kg
        self._fall_n = STANDARD_GRAVITY_MPS2 * (masses.platform_kg + payload_kg + 1.5 * rod_kg)
        self._own_n = STANDARD_GRAVITY_MPS2 * 0.5 * self._own_kg

    def terms(self, angles_rad: Vector, speeds_radps: Vector) -> Terms:
        """M, c + g at a pose in motion. Raises UnreachablePoint where the linkage comes apart."""
        elbows, slopes, arms = self._elbows(angles_rad)
        place = self._platform(elbows)
        forearms = [less(place, elbow) for elbow in elbows]
        columns = self._inverse_of(forearms)
        moves = [
            times(column, dot(forearm, slope))
            for column, forearm, slope in zip(columns, forearms, slopes, strict=True)
        ]
        elbow_biases = [
            times(arm, -speed * speed) for arm, speed in zip(arms, speeds_radps, strict=True)
        ]
        velocity = _combined(moves, speeds_radps)
        asked = []
        for forearm, slope, bias, speed in zip(
            forearms, slopes, elbow_biases, speeds_radps, strict=True
        ):
            turning = less(velocity, times(slope, speed))
            asked.append(dot(forearm, bias) - dot(turning, turning))
        bias = _combined(columns, asked)
        return Terms(*self._matrix(slopes, moves), self._load(slopes, moves, elbow_biases, bias))

    def _inverse_of(self, forearms: list[Vector]) -> list[Vector]:
        """Columns of the inverse of the matrix that has the forearms as rows."""
        first, second, third = forearms
        columns = [cross(second, third), cross(third, first), cross(first, second)]
        volume = dot(first, columns[0])
        if abs(volume) < self._least_m3:
            raise UnreachablePoint(
                "the forearms lie in one plane: the arms do not hold the platform there"
            )
        return [times(column, 1.0 / volume) for column in columns]

    def _matrix(
        self, slopes: list[Vector], moves: list[Vector]
    ) -> tuple[float, float, float, float, float, float]:
        """M: m11, m22, m33, m12, m13, m23."""
        hung, sixth, own = self._hung_kg, self._sixth_kg, self._own_kg
        (t1, t2, t3), (j1, j2, j3) = slopes, moves
        (x1, y1, z1), (x2, y2, z2), (x3, y3, z3) = (
            (hung * jx + sixth * tx, hung * jy + sixth * ty, hung * jz + sixth * tz)
            for (jx, jy, jz), (tx, ty, tz) in zip(moves, slopes, strict=True)
        )
        third1, third2, third3 = (arm[4] for arm in self._arms)
        return (
            own * third1 + dot(j1, (x1, y1, z1)) + sixth * dot(t1, j1),
            own * third2 + dot(j2, (x2, y2, z2)) + sixth * dot(t2, j2),
            own * third3 + dot(j3, (x3, y3, z3)) + sixth * dot(t3, j3),
            dot(j1, (x2, y2, z2)) + sixth * dot(t1, j2),
            dot(j1, (x3, y3, z3)) + sixth * dot(t1, j3),
            dot(j2, (x3, y3, z3)) + sixth * dot(t2, j3),
        )

    def _load(
        self,
        slopes: list[Vector],
        moves: list[Vector],
        elbow_biases: list[Vector],
        bias: Vector,
    ) -> Vector:
        """c + g at the three shafts; an elbow's own bias, towards its shaft, asks for no torque."""
        hung, sixth = self._hung_kg, self._sixth_kg
        (bx, by, bz), ((x1, y1, z1), (x2, y2, z2), (x3, y3, z3)) = bias, elbow_biases
        at_platform = (
            hung * bx + sixth * (x1 + x2 + x3),
            hung * by + sixth * (y1 + y2 + y3),
            hung * bz + sixth * (z1 + z2 + z3) + self._fall_n,
        )
        at_elbow = (sixth * bx, sixth * by, sixth * bz + self._own_n)
        first, second, third = (
            dot(move, at_platform) + dot(slope, at_elbow)
            for move, slope in zip(moves, slopes, strict=True)
        )
        return first, second, third

    def _elbows(self, angles_rad: Vector) -> tuple[list[Vector], list[Vector], list[Vector]]:
        """Elbows less the platform's radius, their slopes, and the arms as vectors."""
        elbows, slopes, arms = [], [], []
        for angle, (east, north, radius_m, upper_m, _) in zip(angles_rad, self._arms, strict=True):
            level, down = upper_m * cos(angle), upper_m * sin(angle)
            reach = radius_m + level
            elbows.append((east * reach, north * reach, -down))
            slopes.append((-east * down, -north * down, -level))
            arms.append((east * level, north * level, -down))
        return elbows, slopes, arms

    def _platform(self, elbows: list[Vector]) -> Vector:
        """The lower meeting point of the three spheres, as `linkage.kinematics` has it."""
        (x1, y1, z1), (x2, y2, z2), (x3, y3, z3) = elbows
        f1, f2, f3 = self._forearms2
        ax, ay, az, bx, by, bz = x2 - x1, y2 - y1, z2 - z1, x3 - x1, y3 - y1, z3 - z1
        nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        n2 = nx * nx + ny * ny + nz * nz
        aq = 0.5 * (ax * ax + ay * ay + az * az + f1 - f2) / n2
        bq = 0.5 * (bx * bx + by * by + bz * bz + f1 - f3) / n2
        qx = aq * (by * nz - bz * ny) + bq * (ny * az - nz * ay)
        qy = aq * (bz * nx - bx * nz) + bq * (nz * ax - nx * az)
        qz = aq * (bx * ny - by * nx) + bq * (nx * ay - ny * ax)
        left = f1 - (qx * qx + qy * qy + qz * qz)
        if left < 0.0:
            raise UnreachablePoint("the forearms do not reach one another")
        down = sqrt(left / n2)
        if nz > 0.0:
            down = -down
        return x1 + qx + down * nx, y1 + qy + down * ny, z1 + qz + down * nz


def _combined(columns: list[Vector], weights: Sequence[float]) -> Vector:
    """Columns added up with weights."""
    a, b, c = columns
    u, v, w = weights
    return (
        a[0] * u + b[0] * v + c[0] * w,
        a[1] * u + b[1] * v + c[1] * w,
        a[2] * u + b[2] * v + c[2] * w,
    )
