"""The terms of a delta's equation of motion at one pose, in plain floats.

The same as `models.dynamics.terms`, which explains it, and gravity as `models.gravity`; a loop
that asks ten thousand times a second cannot afford arrays of three.
"""

from __future__ import annotations

from math import cos, sin, sqrt
from typing import NamedTuple

from foundation.errors import UnreachablePoint
from models.gravity import STANDARD_GRAVITY_MPS2
from models.linkage import Linkage
from models.robot import Masses

LEAST_VOLUME = 1e-4
"""Volume of the forearms' directions below which the platform is as good as loose."""

Vector = tuple[float, float, float]


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
        px, py, pz = self._platform(elbows)
        (x1, y1, z1), (x2, y2, z2), (x3, y3, z3) = (
            (px - ex, py - ey, pz - ez) for ex, ey, ez in elbows
        )
        # Columns of F^-1, with F the forearms as rows.
        c1x, c1y, c1z = y2 * z3 - z2 * y3, z2 * x3 - x2 * z3, x2 * y3 - y2 * x3
        c2x, c2y, c2z = y3 * z1 - z3 * y1, z3 * x1 - x3 * z1, x3 * y1 - y3 * x1
        c3x, c3y, c3z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
        volume = x1 * c1x + y1 * c1y + z1 * c1z
        if abs(volume) < self._least_m3:
            raise UnreachablePoint(
                "the forearms lie in one plane: the arms do not hold the platform there"
            )
        (t1x, t1y, t1z), (t2x, t2y, t2z), (t3x, t3y, t3z) = slopes
        w1 = (x1 * t1x + y1 * t1y + z1 * t1z) / volume
        w2 = (x2 * t2x + y2 * t2y + z2 * t2z) / volume
        w3 = (x3 * t3x + y3 * t3y + z3 * t3z) / volume
        j1x, j1y, j1z = c1x * w1, c1y * w1, c1z * w1
        j2x, j2y, j2z = c2x * w2, c2y * w2, c2z * w2
        j3x, j3y, j3z = c3x * w3, c3y * w3, c3z * w3

        v1, v2, v3 = speeds_radps
        vx = j1x * v1 + j2x * v2 + j3x * v3
        vy = j1y * v1 + j2y * v2 + j3y * v3
        vz = j1z * v1 + j2z * v2 + j3z * v3
        (a1x, a1y, a1z), (a2x, a2y, a2z), (a3x, a3y, a3z) = arms
        s1, s2, s3 = -v1 * v1, -v2 * v2, -v3 * v3
        b1x, b1y, b1z = a1x * s1, a1y * s1, a1z * s1
        b2x, b2y, b2z = a2x * s2, a2y * s2, a2z * s2
        b3x, b3y, b3z = a3x * s3, a3y * s3, a3z * s3
        r1 = _asked(x1, y1, z1, b1x, b1y, b1z, vx - t1x * v1, vy - t1y * v1, vz - t1z * v1)
        r2 = _asked(x2, y2, z2, b2x, b2y, b2z, vx - t2x * v2, vy - t2y * v2, vz - t2z * v2)
        r3 = _asked(x3, y3, z3, b3x, b3y, b3z, vx - t3x * v3, vy - t3y * v3, vz - t3z * v3)
        r1, r2, r3 = r1 / volume, r2 / volume, r3 / volume
        bx = c1x * r1 + c2x * r2 + c3x * r3
        by = c1y * r1 + c2y * r2 + c3y * r3
        bz = c1z * r1 + c2z * r2 + c3z * r3

        hung, sixth, own = self._hung_kg, self._sixth_kg, self._own_kg
        # What the platform point is pushed with: rods share their elbows' acceleration.
        fx = hung * bx + sixth * (b1x + b2x + b3x)
        fy = hung * by + sixth * (b1y + b2y + b3y)
        fz = hung * bz + sixth * (b1z + b2z + b3z) + self._fall_n
        # An elbow goes round its shaft: t . b = 0, so its own bias asks for no torque.
        sx, sy, sz = sixth * bx, sixth * by, sixth * bz + self._own_n
        load = (
            j1x * fx + j1y * fy + j1z * fz + t1x * sx + t1y * sy + t1z * sz,
            j2x * fx + j2y * fy + j2z * fz + t2x * sx + t2y * sy + t2z * sz,
            j3x * fx + j3y * fy + j3z * fz + t3x * sx + t3y * sy + t3z * sz,
        )
        k1x, k1y, k1z = hung * j1x + sixth * t1x, hung * j1y + sixth * t1y, hung * j1z + sixth * t1z
        k2x, k2y, k2z = hung * j2x + sixth * t2x, hung * j2y + sixth * t2y, hung * j2z + sixth * t2z
        k3x, k3y, k3z = hung * j3x + sixth * t3x, hung * j3y + sixth * t3y, hung * j3z + sixth * t3z
        x, y, z = sixth * j1x, sixth * j1y, sixth * j1z
        u, v, w = sixth * j2x, sixth * j2y, sixth * j2z
        p, q, r = sixth * j3x, sixth * j3y, sixth * j3z
        third1, third2, third3 = (arm[4] for arm in self._arms)
        return Terms(
            own * third1 + j1x * k1x + j1y * k1y + j1z * k1z + x * t1x + y * t1y + z * t1z,
            own * third2 + j2x * k2x + j2y * k2y + j2z * k2z + u * t2x + v * t2y + w * t2z,
            own * third3 + j3x * k3x + j3y * k3y + j3z * k3z + p * t3x + q * t3y + r * t3z,
            j1x * k2x + j1y * k2y + j1z * k2z + u * t1x + v * t1y + w * t1z,
            j1x * k3x + j1y * k3y + j1z * k3z + p * t1x + q * t1y + r * t1z,
            j2x * k3x + j2y * k3y + j2z * k3z + p * t2x + q * t2y + r * t2z,
            load,
        )

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
        """The lower meeting point of the three spheres, as `models.linkage.forward` has it."""
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


def _asked(
    x: float,
    y: float,
    z: float,
    bx: float,
    by: float,
    bz: float,
    ux: float,
    uy: float,
    uz: float,
) -> float:
    """f . e'' - |p' - e'|^2: what a forearm's length asks of the platform's acceleration."""
    return x * bx + y * by + z * bz - ux * ux - uy * uy - uz * uz
