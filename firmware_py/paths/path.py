"""What every shape comes down to: targets one after another, with rests."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.models.robot import FloatArray

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
Int64Array = np.ndarray[Any, np.dtype[np.int64]]

MAX_TARGETS = 1_000_000
"""Targets of one repeat: 24 MB a column of three, about what a Pi can hold several times."""


class Space(enum.Enum):
    """What a target is."""

    CARTESIAN = "cartesian"
    """Platform position (x, y, z) [m]; straight lines between targets are not promised."""
    JOINT = "joint"
    """Arm angles [rad]; between targets all arms move in proportion."""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """One repeat of a path.

    targets: (n, 3), m or rad. dwell_s: (n,), time to wait there. rest: (n,), whether the
    arms come to rest there. way_back: (k, 3), targets between the last and the first one,
    both left out, by which an open path returns to its start before it is repeated.
    """

    space: Space
    targets: FloatArray
    dwell_s: FloatArray
    rest: BoolArray
    way_back: FloatArray
    speed_mps: FloatArray | None = None
    """Greatest speed on the way to each target, (n,); inf, and without it, the job's."""
    leg: Int64Array | None = None
    """In a way: the leg that leads to each target, (n,)."""

    def __len__(self) -> int:
        return len(self.targets)

    @property
    def is_closed(self) -> bool:
        """Whether the path ends where it begins, so that a repeat needs no way back."""
        return len(self) > 1 and bool((self.targets[0] == self.targets[-1]).all())


def curve(points_m: FloatArray, spacing_m: float) -> Path:
    """A path through points [m] of shape (n, 3) that is passed without a stop.

    An open curve is repeated by way of a straight line from its end to its start.
    """
    count = len(points_m)
    rest = np.zeros(count, dtype=np.bool_)
    rest[[0, -1]] = True
    return Path(
        space=Space.CARTESIAN,
        targets=points_m,
        dwell_s=np.zeros(count),
        rest=rest,
        way_back=line(points_m[-1], points_m[0], spacing_m)[1:-1],
    )


def line(start_m: FloatArray, end_m: FloatArray, spacing_m: float) -> FloatArray:
    """Points on a straight line [m], both ends included exactly, at most `spacing_m` apart."""
    part = np.linspace(0.0, 1.0, intervals(math.dist(start_m, end_m), spacing_m) + 1)[:, None]
    points: FloatArray = start_m + part * (end_m - start_m)
    points[-1] = end_m
    return points


def intervals(length_m: float, spacing_m: float) -> int:
    """How many equal intervals of at most `spacing_m` make up a length; at least one."""
    # A hair less, so that 1 m at 0.1 m is ten intervals whatever the rounding.
    return max(1, math.ceil(length_m / spacing_m * (1.0 - 1e-12)))


def interval_counts(length_m: FloatArray, spacing_m: float) -> Int64Array:
    """As intervals, of each length, (n,)."""
    pieces = np.ceil(length_m / spacing_m * (1.0 - 1e-12))
    counts: Int64Array = np.maximum(1.0, pieces).astype(np.int64)
    return counts


def level(centre_m: tuple[float, float, float], x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """Points of a level curve about its centre, (n, 3)."""
    return np.stack([centre_m[0] + x_m, centre_m[1] + y_m, np.full(len(x_m), centre_m[2])], -1)
