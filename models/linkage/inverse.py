"""Inverse kinematics: platform position to arm angles, in closed form."""

from __future__ import annotations

import numpy as np

from models.linkage.arms import Linkage
from models.linkage.status import SINGULAR_MARGIN, ArmAngles, Status
from models.robot import FloatArray


def inverse(linkage: Linkage, position_m: FloatArray) -> ArmAngles:
    """Commanded arm angles [rad] for platform positions [m] of shape (..., 3)."""
    p = np.asarray(position_m, dtype=np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        c, s = np.cos(linkage.azimuth_rad), np.sin(linkage.azimuth_rad)
        length_m, forearm_m = linkage.upper_arm_m, linkage.forearm_m
        px, py, pz = (p[..., axis, None] for axis in range(3))
        u = c * px + s * py - linkage.radius_m
        v = c * py - s * px
        k = (u**2 + v**2 + pz**2 + length_m**2 - forearm_m**2) / (2 * length_m)
        h2 = u**2 + pz**2 - k**2
        near = np.abs(h2) < (SINGULAR_MARGIN * forearm_m) ** 2
        h = np.sqrt(np.where(near, np.maximum(h2, 0.0), h2))
        theta = np.arctan2(-pz * k - u * h, u * k - pz * h)
        a = u - length_m * np.cos(theta)
        f = np.stack(
            np.broadcast_arrays(c * a - s * v, s * a + c * v, pz + length_m * np.sin(theta)), -1
        )
        f /= np.broadcast_to(forearm_m, f.shape[:-1])[..., None]
        f1, f2, f3 = f[..., 0, :], f[..., 1, :], f[..., 2, :]
        n = np.cross(f1 - f2, f1 - f3)
        det = np.einsum("...i,...i", f1, n)
        tilt = n[..., 2]
        lower = det * tilt < 0.0
    singular = near.any(-1) | (np.abs(det) < SINGULAR_MARGIN)
    singular |= np.abs(tilt) < SINGULAR_MARGIN * np.linalg.norm(n, axis=-1)
    status = np.full(singular.shape, Status.OK, dtype=np.uint8)
    status[singular] = Status.SINGULAR
    bad = np.isnan(theta).any(-1) | (~lower & ~singular)
    status[bad] = Status.UNREACHABLE
    angles_rad = theta - linkage.home_offset_rad
    angles_rad[bad] = np.nan
    return ArmAngles(angles_rad, status)
