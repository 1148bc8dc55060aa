"""Where the nominal robot's arms must stand for a point: what the controller of the proof believes.

Own code, from the triangle of each arm: independent of the models that are being proven.
"""

from __future__ import annotations

import numpy as np

from deltactl.foundation.errors import UnreachablePoint
from deltactl.proof.robot.as_built import Body, FloatArray


def arm_angles(points_m: FloatArray, body: Body) -> FloatArray:
    """Arm angles (n, 3) [rad] for platform positions (n, 3) [m], knees outward.

    Raises UnreachablePoint when a rod cannot reach.
    """
    columns = []
    for arm in range(3):
        azimuth = body.azimuth_rad[arm]
        outward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        sideways = np.array([-outward[1], outward[0], 0.0])
        radius_m = body.base_radius_m[arm] - body.platform_radius_m[arm]
        # In the arm's plane, seen from its hinge: how far out and how far down the wrist is.
        out = points_m @ outward - radius_m
        down = -points_m[:, 2]
        in_plane = body.forearm_m[arm] ** 2 - (points_m @ sideways) ** 2
        reach = np.hypot(out, down)
        upper = body.upper_arm_m[arm]
        cosine = (upper**2 + reach**2 - in_plane) / (2.0 * upper * reach)
        if not np.all(np.abs(cosine) <= 1.0):
            at = points_m[int(np.argmax(np.abs(cosine)))]
            raise UnreachablePoint(f"arm {arm + 1} cannot reach {np.round(at, 4).tolist()} m")
        columns.append(np.arctan2(down, out) - np.arccos(cosine))
    return np.stack(columns, axis=1)
