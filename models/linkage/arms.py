"""The linkage as the kinematics see it, five numbers an arm, and how a pose came out."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from enum import IntEnum
from functools import cached_property
from math import cos, sin
from typing import Any, NamedTuple

import numpy as np

from deltactl.models.robot import ARMS, FloatArray, Geometry

StatusArray = np.ndarray[Any, np.dtype[np.uint8]]


class Status(IntEnum):
    """One code a pose; the worst that holds."""

    OK = 0
    UNREACHABLE = 1
    SINGULAR = 2


STATUS_TEXT: dict[Status, str] = {
    Status.OK: "reachable",
    Status.UNREACHABLE: "out of reach: the linkage cannot be assembled there; move it inside",
    Status.SINGULAR: "singular: the platform jams or gets loose there; keep away from it",
}
"""Reads on after 'the pose is'."""

SINGULAR_MARGIN = 1e-6
"""A pose whose serial or parallel margin is below this (in size) is reported as SINGULAR.

There the closed forms lose more than half their digits: rounding of 1e-16 grows to 1e-10.
It marks where the numbers stop being good, not where a machine should stop; that is
`limits.singularity_margin` of the robot file, which is far larger.
"""


class ArmAngles(NamedTuple):
    """Result of `inverse`."""

    angles_rad: FloatArray
    """Commanded arm angles, shape (..., 3); NaN where unreachable."""
    status: StatusArray
    """`Status` of each pose, shape (...)."""


class PlatformPosition(NamedTuple):
    """Result of `forward`."""

    position_m: FloatArray
    """Platform position, shape (..., 3); NaN where unreachable or undetermined."""
    status: StatusArray
    """`Status` of each pose, shape (...)."""


class PlainArm(NamedTuple):
    """One arm's constants of the inverse kinematics as plain floats."""

    east: float
    north: float
    radius_m: float
    upper_arm_m: float
    upper2_less_forearm2_m2: float
    half_per_upper_arm: float
    edge_m2: float
    """Square of the serial margin's limit times the forearm."""
    home_offset_rad: float


class PlainLinkage(NamedTuple):
    """All arms' constants, and the limits below which a pose is singular."""

    arms: tuple[PlainArm, ...]
    least_volume_m3: float
    least_turn_m2: float


@dataclass(frozen=True, eq=False)
class Linkage:
    """Five numbers an arm, each of shape (3,), or (..., 3) to differ from pose to pose.

    Values with leading dimensions must broadcast against the poses they are used with
    (arms that grow while warming up, for instance). The arrays are copies and read-only.
    Raises ValueError for values that are not finite, lengths that are not positive, or
    a last dimension that is not 3.
    """

    radius_m: FloatArray
    """Base minus platform radius, the only combination the linkage sees."""
    upper_arm_m: FloatArray
    forearm_m: FloatArray
    azimuth_rad: FloatArray
    """Direction of the arm about z."""
    home_offset_rad: FloatArray
    """True angle minus commanded angle; angles given to and by the kinematics are commanded."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = np.array(getattr(self, field.name), dtype=np.float64)
            if value.shape[-1:] != (ARMS,):
                raise ValueError(f"{field.name}: the last dimension must be 3, got {value.shape}")
            if not np.isfinite(value).all():
                raise ValueError(f"{field.name}: must be finite, got {value.tolist()}")
            value.flags.writeable = False
            object.__setattr__(self, field.name, value)
        for name in ("upper_arm_m", "forearm_m"):
            if getattr(self, name).min() <= 0.0:
                raise ValueError(f"{name}: must be positive, got {getattr(self, name).tolist()}")

    @classmethod
    def of(cls, geometry: Geometry) -> Linkage:
        """The linkage of a robot file's geometry."""
        return cls(
            radius_m=geometry.radius_m,
            upper_arm_m=np.broadcast_to(geometry.upper_arm_m, (ARMS,)),
            forearm_m=np.broadcast_to(geometry.forearm_m, (ARMS,)),
            azimuth_rad=geometry.azimuth_rad,
            home_offset_rad=np.deg2rad(np.asarray(geometry.home_offset_deg, dtype=np.float64)),
        )

    def with_(self, **changes: Any) -> Linkage:
        """A copy with some of the arrays replaced (a number counts for all arms)."""
        widened = {
            name: np.broadcast_to(value, (ARMS,)) if np.ndim(value) == 0 else value
            for name, value in changes.items()
        }
        return replace(self, **widened)

    def values(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """The five arrays, in the order of the fields."""
        return (
            self.radius_m,
            self.upper_arm_m,
            self.forearm_m,
            self.azimuth_rad,
            self.home_offset_rad,
        )

    @cached_property
    def is_constant(self) -> bool:
        """Whether every value is the same for all poses."""
        return all(value.ndim == 1 for value in self.values())

    @cached_property
    def plain(self) -> PlainLinkage:
        """The linkage as plain floats. Raises ValueError when it differs from pose to pose."""
        if not self.is_constant:
            raise ValueError("one target needs one linkage, not one that differs from pose to pose")
        columns = zip(*(value.tolist() for value in self.values()), strict=True)
        return PlainLinkage(
            arms=tuple(_plain_arm(*column) for column in columns),
            least_volume_m3=float(SINGULAR_MARGIN * self.forearm_m.prod()),
            least_turn_m2=float(SINGULAR_MARGIN * self.forearm_m.max() ** 2),
        )


def _plain_arm(
    radius_m: float,
    upper_arm_m: float,
    forearm_m: float,
    azimuth_rad: float,
    home_offset_rad: float,
) -> PlainArm:
    return PlainArm(
        east=cos(azimuth_rad),
        north=sin(azimuth_rad),
        radius_m=radius_m,
        upper_arm_m=upper_arm_m,
        upper2_less_forearm2_m2=upper_arm_m**2 - forearm_m**2,
        half_per_upper_arm=0.5 / upper_arm_m,
        edge_m2=(SINGULAR_MARGIN * forearm_m) ** 2,
        home_offset_rad=home_offset_rad,
    )
