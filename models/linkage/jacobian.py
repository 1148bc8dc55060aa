"""How the platform moves with the arms, and how far a pose is from losing that.

Let f be an arm's forearm vector (elbow to platform), L its upper arm and t the unit vector in
which the elbow goes as the angle grows. The forearm keeps its length, so that

    f . dp = L (f . t) d angle

for each arm; with F the rows f, dp = F^-1 diag(L f . t) d angle. F^-1 has the cross products of
two forearms each for columns, over the volume that the three span. A pose is singular where
one f . t is 0 (serial: an arm outstretched or folded) or the volume is (parallel: the forearms
lie in one plane); Gosselin and Angeles 1990, 'Singularity analysis of closed-loop
kinematic chains'.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from deltactl.models.linkage.arms import Linkage
from deltactl.models.robot import FloatArray

_NEXT, _LAST = [1, 2, 0], [2, 0, 1]


class _Vectors(NamedTuple):
    """One vector an arm: each component has shape (..., 3), the last dimension being the arm."""

    x: FloatArray
    y: FloatArray
    z: FloatArray

    def dot(self, other: _Vectors) -> FloatArray:
        """Scalar products arm by arm, (..., 3)."""
        products: FloatArray = self.x * other.x + self.y * other.y + self.z * other.z
        return products

    def crosses(self) -> _Vectors:
        """For each arm the cross product of the next arm's vector and the one after."""
        x, y, z = (component[..., _NEXT] for component in self)
        u, v, w = (component[..., _LAST] for component in self)
        return _Vectors(y * w - z * v, z * u - x * w, x * v - y * u)


def jacobian(linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray) -> FloatArray:
    """d position / d angle [m/rad], shape (..., 3, 3): row = x, y, z, column = arm.

    `angles_rad` (..., 3), commanded, and `position_m` (..., 3) must belong together, as
    `inverse` or `forward` give them. NaN where the pose is unreachable or exactly singular.
    """
    forearm, tangent = _vectors(linkage, angles_rad, position_m)
    crosses = forearm.crosses()
    volume = forearm.dot(crosses)
    with np.errstate(invalid="ignore", divide="ignore"):
        gain = linkage.upper_arm_m * forearm.dot(tangent) / np.where(volume == 0.0, np.nan, volume)
    return np.stack([component * gain for component in crosses], axis=-2)


def least_gain(linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray) -> FloatArray:
    """Smallest singular value of the Jacobian over the mean upper arm, shape (...).

    How far the platform moves, at least, in the direction in which it moves least. 0 where the
    pose is unreachable or exactly singular.
    """
    moved = np.nan_to_num(jacobian(linkage, angles_rad, position_m))
    gains = np.linalg.svd(moved, compute_uv=False)
    least: FloatArray = gains[..., -1] / linkage.upper_arm_m.mean(axis=-1)
    return least


def serial_margin(linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray) -> FloatArray:
    """Sine of the angle between each forearm and the plane of its upper arm and motor axis.

    Shape (..., 3). 0: the arm is outstretched or folded and the platform cannot follow it
    (edge of the workspace); negative: the elbow is on the inner side.
    """
    forearm, tangent = _vectors(linkage, angles_rad, position_m)
    sine: FloatArray = forearm.dot(tangent) / linkage.forearm_m
    return sine


def parallel_margin(linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray) -> FloatArray:
    """Volume spanned by the three forearm directions, shape (...).

    1: they are at right angles; 0: they lie in one plane and the platform gives way though
    the arms are held; negative: the platform is above its elbows. The smallest singular
    value of the three directions is at least 2/3 of this.
    """
    forearm, _ = _vectors(linkage, angles_rad, position_m)
    crosses = forearm.crosses()
    volume = forearm.dot(crosses)[..., 0] / linkage.forearm_m.prod(axis=-1)
    below: FloatArray = volume * -np.sign(crosses.z.sum(axis=-1))
    return below


def _vectors(
    linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray
) -> tuple[_Vectors, _Vectors]:
    """Forearm vectors [m] and unit elbow tangents."""
    position_m = np.asarray(position_m, dtype=np.float64)
    true_rad = np.asarray(angles_rad, dtype=np.float64) + linkage.home_offset_rad
    cos, sin = np.cos(true_rad), np.sin(true_rad)
    east, north = np.cos(linkage.azimuth_rad), np.sin(linkage.azimuth_rad)
    reach_m = linkage.radius_m + linkage.upper_arm_m * cos
    forearm = _Vectors(
        position_m[..., 0, None] - reach_m * east,
        position_m[..., 1, None] - reach_m * north,
        position_m[..., 2, None] + linkage.upper_arm_m * sin,
    )
    return forearm, _Vectors(-sin * east, -sin * north, -cos)
