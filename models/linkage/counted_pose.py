"""Where a robot is by its step counts."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from deltactl.models.linkage.vectors import Vector


def counted_pose(
    counts: Sequence[int], rad_per_step: float, position_of: Callable[[Vector], Vector]
) -> tuple[Vector, Vector | None]:
    """Arm angles [rad], and the platform's position [m]; None where it cannot be assembled.

    position_of: forward kinematics of one pose, NaN where there is none.
    """
    first, second, third = (count * rad_per_step for count in counts)
    angles_rad = (first, second, third)
    position_m = position_of(angles_rad)
    return angles_rad, position_m if all(map(math.isfinite, position_m)) else None
