"""Forward kinematics: arm angles to platform position, the lower meeting point of three spheres."""

from __future__ import annotations

import numpy as np

from models.linkage.arms import Linkage
from models.linkage.status import SINGULAR_MARGIN, PlatformPosition, Status
from models.robot import FloatArray


def forward(linkage: Linkage, angles_rad: FloatArray) -> PlatformPosition:
    """Platform positions [m] for commanded arm angles [rad] of shape (..., 3)."""
    theta = np.asarray(angles_rad, dtype=np.float64) + linkage.home_offset_rad
    length_m, l2 = linkage.upper_arm_m, linkage.forearm_m**2
    with np.errstate(invalid="ignore", divide="ignore"):
        reach = linkage.radius_m + length_m * np.cos(theta)
        elbow = np.stack(
            [
                reach * np.cos(linkage.azimuth_rad),
                reach * np.sin(linkage.azimuth_rad),
                -length_m * np.sin(theta),
            ],
            -1,
        )
        e1 = elbow[..., 0, :]
        a, b = elbow[..., 1, :] - e1, elbow[..., 2, :] - e1
        n = np.cross(a, b)
        n2 = np.einsum("...i,...i", n, n)
        ka = 0.5 * (l2[..., 0] - l2[..., 1] + np.einsum("...i,...i", a, a))
        kb = 0.5 * (l2[..., 0] - l2[..., 2] + np.einsum("...i,...i", b, b))
        q = (ka[..., None] * np.cross(b, n) + kb[..., None] * np.cross(n, a)) / n2[..., None]
        g = l2[..., 0] - np.einsum("...i,...i", q, q)
        scale = linkage.forearm_m.prod(-1) ** 2
        near = np.abs(g) * n2 < SINGULAR_MARGIN**2 * scale
        t = np.sqrt(np.where(near, np.maximum(g, 0.0), g) / n2)
        p = e1 + q - (np.where(n[..., 2] < 0.0, -t, t))[..., None] * n
    near |= n[..., 2] ** 2 < SINGULAR_MARGIN**2 * n2
    near |= n2 < SINGULAR_MARGIN**2 * l2[..., 0] ** 2
    status = np.full(near.shape, Status.OK, dtype=np.uint8)
    bad = np.isnan(p).any(-1)
    p[bad] = np.nan
    status[bad] = Status.UNREACHABLE
    status[near] = Status.SINGULAR
    return PlatformPosition(p, status)
