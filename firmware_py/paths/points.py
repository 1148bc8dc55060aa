"""Straight lines between points, with a rest at each."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from deltactl.firmware_py.paths.path import Path, Space, intervals, line

Point = tuple[float, float, float]


def target_count(points_m: Sequence[Point], spacing_m: float) -> int:
    """How many targets the path has."""
    pairs = itertools.pairwise(points_m)
    return 1 + sum(intervals(math.dist(*pair), spacing_m) for pair in pairs)


def points(points_m: Sequence[Point], dwell_s: float, spacing_m: float) -> Path:
    """Lines sampled at `spacing_m`; every given point is a target of its own."""
    corners = np.asarray(points_m, dtype=np.float64)
    lines = [line(start, end, spacing_m)[1:] for start, end in itertools.pairwise(corners)]
    targets = np.concatenate([corners[:1], *lines])
    rest = np.zeros(len(targets), dtype=np.bool_)
    rest[np.cumsum([0, *(len(part) for part in lines)])] = True
    return Path(
        space=Space.CARTESIAN,
        targets=targets,
        dwell_s=np.where(rest, dwell_s, 0.0),
        rest=rest,
        way_back=line(corners[-1], corners[0], spacing_m)[1:-1],
    )
