"""How a pose came out, and the solutions that carry it."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from deltactl.models.robot import FloatArray

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
