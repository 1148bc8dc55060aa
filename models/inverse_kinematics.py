"""Targets to step counts: one contract for inverse kinematics, and the way from angles to counts.

A job chooses geometry or a network; a planner sees an `InverseKinematics` either way and
asks `TargetMapper` for counts, which are checked against the arm limits.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from deltactl.foundation.errors import LimitExceeded, Refusal
from deltactl.models.linkage import Linkage, inverse_one
from deltactl.models.robot import ARMS, AnyDrive, FloatArray, Geometry

USE_GEOMETRY = "use inverse_kinematics: {kind: geometry}"
"""In a job whose network cannot be taken."""


class InverseKinematics(Protocol):
    """Position to commanded arm angles; one and many give the same numbers to the last bit."""

    def angles_rad(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
        """Angles [rad] of one target [m].

        Raises UnreachablePoint where the linkage cannot go, LimitExceeded where the model
        may not be asked.
        """

    def angles_rad_many(self, position_m: FloatArray) -> FloatArray:
        """Angles [rad] of targets [m], both (n, 3). Raises at the first target that fails."""


class GeometricInverse:
    """Inverse kinematics in closed form (`deltactl.models.linkage`)."""

    def __init__(self, geometry: Geometry):
        self.linkage = Linkage.of(geometry)

    def angles_rad(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
        """Commanded arm angles [rad] of one target [m]. Raises UnreachablePoint."""
        return inverse_one(self.linkage, x_m, y_m, z_m)

    def angles_rad_many(self, position_m: FloatArray) -> FloatArray:
        """Angles [rad] of targets [m], both (n, 3). Raises UnreachablePoint.

        Target by target: the vectorised form may differ in the last bit, which is enough to
        round to another count now and then.
        """
        return np.array(
            [inverse_one(self.linkage, *target) for target in targets_of(position_m)],
            dtype=np.float64,
        ).reshape(-1, ARMS)


class TargetMapper:
    """Turns targets into step counts that respect the arm limits.

    Count 0 is commanded angle 0. A limit falls on the nearest whole microstep, so an arm
    stays within half a microstep of it.
    """

    def __init__(
        self, kinematics: InverseKinematics, drive: AnyDrive, arm_limits_deg: tuple[float, float]
    ):
        self.kinematics = kinematics
        self.rad_per_step = drive.rad_per_step
        self.arm_limits_deg = arm_limits_deg
        low_deg, high_deg = arm_limits_deg
        self.low_steps = round(math.radians(low_deg) / self.rad_per_step)
        self.high_steps = round(math.radians(high_deg) / self.rad_per_step)
        self._angles_rad = kinematics.angles_rad

    def counts(self, x_m: float, y_m: float, z_m: float) -> tuple[int, int, int]:
        """Step counts of one target [m]. Raises UnreachablePoint or LimitExceeded."""
        first_rad, second_rad, third_rad = self._angles_rad(x_m, y_m, z_m)
        step_rad = self.rad_per_step
        first, second, third = (
            round(first_rad / step_rad),
            round(second_rad / step_rad),
            round(third_rad / step_rad),
        )
        low, high = self.low_steps, self.high_steps
        if not (low <= first <= high and low <= second <= high and low <= third <= high):
            raise self._beyond((x_m, y_m, z_m), (first, second, third))
        return first, second, third

    def _beyond(
        self, target_m: tuple[float, float, float], counts: tuple[int, ...]
    ) -> LimitExceeded:
        low_deg, high_deg = self.arm_limits_deg
        arm, count = next(
            (arm, count)
            for arm, count in enumerate(counts, start=1)
            if not self.low_steps <= count <= self.high_steps
        )
        angle_deg = math.degrees(count * self.rad_per_step)
        where = "target ({:.4f}, {:.4f}, {:.4f}) m: ".format(*target_m)
        return LimitExceeded.at(
            where,
            Refusal(
                f"arm {arm} would be at {angle_deg:.2f} deg, outside its limits of "
                f"{low_deg:g} to {high_deg:g} deg (limits.arm_deg, or its default)"
            ),
        )


def targets_of(position_m: FloatArray) -> list[tuple[float, float, float]]:
    """Rows as plain floats: arithmetic on numpy scalars is several times slower."""
    rows: list[tuple[float, float, float]]
    rows = np.asarray(position_m, dtype=np.float64).reshape(-1, ARMS).tolist()
    return rows
