"""Samples as Zhao 2023 draws them: random arm angles, and where the robot is then; and the split.

Of uniform triples in [-20, 110] degrees 1.7 % lie past the serial singularity, on the other elbow
branch, where one position has two answers. Those, and what is next to them, are left out, as the
survey of `deltactl collect` does.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.models.linkage import Linkage, Status, forward, parallel_margin, serial_margin
from deltactl.models.robot import ARMS, FloatArray

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
