"""How the platform moves with the arms, and how far a pose is from losing that.

For each arm with upper arm L, unit tangent t (where the elbow goes as the angle grows) and
forearm vector f (elbow to platform), the closed loop gives f . dp = L (f . t) dtheta.
With F the rows f and B = diag(L f . t): dp = F^-1 B dtheta (Clavel's delta, e.g.
Merlet, Parallel Robots, 2nd ed., section 5.2).
"""

from __future__ import annotations

import numpy as np

from models.linkage.arms import Linkage
from models.robot import FloatArray


def jacobian(linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray) -> FloatArray:
    """d position / d angle [m/rad], shape (..., 3, 3): row = x, y, z, column = arm.

    `angles_rad` (..., 3) and `position_m` (..., 3) must belong together (`inverse` or
    `forward`). NaN where the pose is exactly singular or not reachable.
    """
    forearm_m, tangent = _vectors(linkage, angles_rad, position_m)
    crosses = _crosses(forearm_m)
    volume = (forearm_m[..., 0, :] * crosses[..., 0, :]).sum(-1)
    lever = linkage.upper_arm_m * (forearm_m * tangent).sum(-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        gain = np.where(volume == 0.0, np.nan, 1.0 / volume)[..., None] * lever
    columns: FloatArray = crosses * gain[..., None]
    return np.swapaxes(columns, -1, -2)


def serial_margin(linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray) -> FloatArray:
    """Sine of the angle between each forearm and the plane of its upper arm and motor axis.

    Shape (..., 3). 0: arm outstretched or folded, the platform cannot follow that arm
    (serial singularity, edge of the workspace); negative: elbow on the inner side.
    """
    forearm_m, tangent = _vectors(linkage, angles_rad, position_m)
    sine: FloatArray = (forearm_m * tangent).sum(-1) / linkage.forearm_m
    return sine


def parallel_margin(linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray) -> FloatArray:
    """Volume spanned by the three forearm directions, shape (...).

    1: they are at right angles; 0: they lie in one plane and the platform can move though
    the arms are held (parallel singularity); negative: platform above its elbows. The
    smallest singular value of the three directions is between 2/3 of this and its cube root.
    """
    forearm_m, _ = _vectors(linkage, angles_rad, position_m)
    first, second, third = (
        forearm_m[..., arm, :] / linkage.forearm_m[..., arm, None] for arm in range(3)
    )
    volume = (first * np.cross(second, third)).sum(-1)
    turn = np.cross(first - second, first - third)[..., 2]
    signed: FloatArray = volume * -np.sign(turn)
    return signed


def _vectors(
    linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Forearm vectors [m] (elbow to platform) and unit elbow tangents, both (..., arm, xyz)."""
    true_rad = np.asarray(angles_rad, dtype=np.float64) + linkage.home_offset_rad
    cos, sin = np.cos(true_rad), np.sin(true_rad)
    east, north = np.cos(linkage.azimuth_rad), np.sin(linkage.azimuth_rad)
    reach_m = linkage.radius_m + linkage.upper_arm_m * cos
    elbow_m = np.stack([reach_m * east, reach_m * north, -linkage.upper_arm_m * sin], axis=-1)
    tangent = np.stack([-sin * east, -sin * north, -cos], axis=-1)
    return np.asarray(position_m, dtype=np.float64)[..., None, :] - elbow_m, tangent


def _crosses(forearm_m: FloatArray) -> FloatArray:
    """For each arm the cross product of the other two forearm vectors, in cyclic order."""
    rolled = np.roll(forearm_m, -1, axis=-2)
    return np.cross(rolled, np.roll(forearm_m, -2, axis=-2))
