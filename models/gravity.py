"""Torque that gravity puts on the arm joints of a delta at rest.

Lumped masses: an upper arm at its middle; a pair of forearm rods half at the elbow and half
at the platform (exact for the force balance of a uniform rod hung at both ends); platform
and payload at the platform point, carried to the joints by the transposed Jacobian.
"""

from __future__ import annotations

import numpy as np

from deltactl.models.linkage import Linkage, jacobian
from deltactl.models.robot import ARMS, FloatArray, Masses

STANDARD_GRAVITY_MPS2 = 9.80665


def gravity_torque_nm(
    linkage: Linkage,
    masses: Masses,
    angles_rad: FloatArray,
    position_m: FloatArray,
    payload_kg: float | FloatArray = 0.0,
    per_kg_nm: FloatArray | None = None,
) -> FloatArray:
    """Torque of gravity at each joint [N m], shape (..., 3): minus dU / d angle.

    Positive torque acts in the direction of positive angle, so gravity pulls an arm down
    with a positive torque and the motor holds it with the opposite one. `angles_rad` and
    `position_m` (..., 3) must belong together; `payload_kg` is a number or of shape (...);
    `per_kg_nm` is what `torque_per_kg_nm` gave for the same poses, if it is known already.
    NaN where the pose is singular or unreachable.
    """
    true_rad = np.asarray(angles_rad, dtype=np.float64) + linkage.home_offset_rad
    at_elbow_kg = 0.5 * (masses.upper_arm_kg + masses.forearm_kg)
    hung_kg = masses.platform_kg + 0.5 * ARMS * masses.forearm_kg + np.asarray(payload_kg)
    if per_kg_nm is None:
        per_kg_nm = torque_per_kg_nm(linkage, angles_rad, position_m)
    own_nm = STANDARD_GRAVITY_MPS2 * at_elbow_kg * linkage.upper_arm_m * np.cos(true_rad)
    torque: FloatArray = own_nm + hung_kg[..., None] * per_kg_nm
    return torque


def torque_per_kg_nm(
    linkage: Linkage, angles_rad: FloatArray, position_m: FloatArray
) -> FloatArray:
    """Torque at each joint of one kilogram at the platform point [N m], shape (..., 3)."""
    falls_m = jacobian(linkage, angles_rad, position_m)[..., 2, :]
    torque: FloatArray = -STANDARD_GRAVITY_MPS2 * falls_m
    return torque
