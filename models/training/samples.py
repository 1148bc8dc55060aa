"""Positions to train and test on: spread over a domain, on its edges, and where it is hard.

Near a stretched or folded arm the angle changes like the square root of the distance. Even
samples hardly ever fall there, and a network that saw none is wrong there by far the most.

As Zhao 2023 draws them: random arm angles, and where the robot is then; and the split.

1.7 % of uniform triples in [-20, 110] degrees are past the serial singularity, on the other elbow
branch, where one position has two answers. Those, and what is next to them, are left out, as the
survey of `deltactl network collect` does.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.models.linkage import (
    Linkage,
    Status,
    forward,
    inverse,
    parallel_margin,
    serial_margin,
)
from deltactl.models.network.metadata import Box, Cylinder
from deltactl.models.robot import ARMS, FloatArray

INFLATE = 0.3
"""Points for the edges come from a box larger by this share of its size on every side."""

_SEARCH_ROUNDS, _SEARCH_POINTS = 60, 256


def spread(domain: Cylinder | Box, rng: np.random.Generator, count: int) -> FloatArray:
    """Evenly inside the domain; shape (count, 3)."""
    low_m, high_m = domain.bounding_box()
    position_m = rng.uniform(low_m, high_m, (2 * count + 100, 3))
    inside = np.array([domain.contains(*point) for point in position_m.tolist()])
    # pi / 4 of a box is a cylinder, so twice as many always leave enough.
    chosen: FloatArray = position_m[inside][:count]
    return chosen


def edges(domain: Cylinder | Box, rng: np.random.Generator, count: int) -> FloatArray:
    """On the faces, edges and corners of the domain; shape (count, 3)."""
    low_m, high_m = domain.bounding_box()
    margin_m = INFLATE * (high_m - low_m)
    position_m = rng.uniform(low_m - margin_m, high_m + margin_m, (4 * count + 100, 3))
    clipped = domain.clip(position_m)
    on_edge: FloatArray = clipped[np.any(clipped != position_m, axis=1)][:count]
    return on_edge


def around(
    domain: Cylinder | Box,
    anchor_m: FloatArray,
    rng: np.random.Generator,
    count: int,
    finest_m: float,
) -> FloatArray:
    """Close to a point, at all scales from `finest_m` up to the domain; shape (count, 3).

    Every coordinate has a scale of its own, evenly in its logarithm.
    """
    low_m, high_m = domain.bounding_box()
    coarsest = np.log10(high_m - low_m)
    scale_m = 10.0 ** rng.uniform(np.log10(finest_m), coarsest, (count, 3))
    sign = rng.choice([-1.0, 1.0], (count, 3))
    return domain.clip(anchor_m + sign * scale_m)


def hardest(domain: Cylinder | Box, linkage: Linkage, rng: np.random.Generator) -> FloatArray:
    """The point of the domain where an arm is closest to stretched or folded; shape (3,).

    Raises NetworkError when part of the domain cannot be reached.
    """
    points_m = np.concatenate([spread(domain, rng, 2000), edges(domain, rng, 2000)])
    low_m, high_m = domain.bounding_box()
    reach_m = 0.1 * (high_m - low_m)
    for _ in range(_SEARCH_ROUNDS):
        best_m: FloatArray = points_m[np.argmin(_margin(linkage, points_m, domain))]
        step_m = rng.normal(size=(_SEARCH_POINTS, 3)) * reach_m
        points_m = np.vstack([best_m, domain.clip(best_m + step_m)])
        reach_m = 0.7 * reach_m
    return best_m


def labels_rad(linkage: Linkage, position_m: FloatArray) -> FloatArray:
    """Commanded arm angles [rad] in float64, shape (n, 3). Raises NetworkError off the workspace.

    Poses reported as singular have good angles (only their derivatives are not) and count.
    """
    angles_rad = inverse(linkage, position_m).angles_rad
    missing = ~np.isfinite(angles_rad).all(axis=1)
    if missing.any():
        x_m, y_m, z_m = position_m[np.argmax(missing)]
        raise NetworkError(
            f"({x_m:.4f}, {y_m:.4f}, {z_m:.4f}) m cannot be reached; make the domain smaller"
        )
    return angles_rad


def _margin(linkage: Linkage, position_m: FloatArray, domain: Cylinder | Box) -> FloatArray:
    angles_rad = labels_rad(linkage, position_m)
    least: FloatArray = serial_margin(linkage, angles_rad, position_m).min(axis=1)
    return least


IntArray = np.ndarray[Any, np.dtype[np.int64]]

SMALLEST_MARGIN = 0.05
"""As `limits.singularity_margin` of the robot files."""
TRAINED_PART = 0.75
"""Zhao 2023, section 3: 75 % train, 25 % validate."""
_SPLIT_STREAM = 75
_FEWEST = 0.05


def random_poses(
    linkage: Linkage,
    count: int,
    angle_deg: tuple[float, float],
    seed: int,
    smallest_margin: float = SMALLEST_MARGIN,
) -> tuple[FloatArray, FloatArray]:
    """Positions [m] and commanded arm angles [rad], both (count, 3).

    Raises NetworkError when hardly any triple of angles can be assembled.
    """
    rng = np.random.default_rng(seed)
    position_m, angles_rad = np.empty((0, ARMS)), np.empty((0, ARMS))
    drawn = 0
    while len(angles_rad) < count:
        triples = np.deg2rad(rng.uniform(*angle_deg, (max(count, 512), ARMS)))
        pose = forward(linkage, triples)
        margin = np.minimum(
            serial_margin(linkage, triples, pose.position_m).min(axis=1),
            parallel_margin(linkage, triples, pose.position_m),
        )
        good = (pose.status == Status.OK) & (margin >= smallest_margin)
        position_m = np.concatenate([position_m, pose.position_m[good]])
        angles_rad = np.concatenate([angles_rad, triples[good]])
        drawn += len(triples)
        if len(angles_rad) < _FEWEST * drawn:
            raise NetworkError(
                f"only {len(angles_rad)} of {drawn} random arm angles can be assembled; "
                "check the robot's lengths"
            )
    return position_m[:count], angles_rad[:count]


def split(count: int, seed: int) -> tuple[IntArray, IntArray]:
    """Rows to train on (three quarters) and rows to judge by, both in random order."""
    order = np.random.default_rng([seed, _SPLIT_STREAM]).permutation(count)
    cut = round(TRAINED_PART * count)
    return order[:cut], order[cut:]
