"""The terms of a delta's equation of motion, vectorised over poses; all at the arms' shafts.

    M(a) a'' + c(a, a') + g(a) = torque                      (Uzunovic 2013, equation 3)

Upper arms and forearm rods are uniform and thin. A rod with ends at speeds u and v has the
kinetic energy m (u.u + u.v + v.v) / 6, exactly; with A the elbows' and J the platform's
derivatives by the arm angles, m_u, m_f, m_p the masses of an upper arm, a pair of rods, platform:

    M = (m_u + m_f) L^2 / 3 (diagonal) + m_f / 6 (A^T J + J^T A) + (m_p + m_f) J^T J

g is minus `models.gravity`, which is exact for such rods. Friction and rotors are not in here.
"""

from __future__ import annotations

import numpy as np

from deltactl.models.gravity import STANDARD_GRAVITY_MPS2
from deltactl.models.linkage import Linkage, jacobian
from deltactl.models.robot import ARMS, FloatArray, Masses


def mass_matrix_kgm2(
    linkage: Linkage,
    masses: Masses,
    angles_rad: FloatArray,
    position_m: FloatArray,
    payload_kg: float = 0.0,
) -> FloatArray:
    """M at poses (..., 3), shape (..., 3, 3) [kg m2]. NaN where a pose is singular."""
    elbows, platform = (
        _elbow_slopes_m(linkage, angles_rad),
        jacobian(linkage, angles_rad, position_m),
    )
    rod_kg, upper_kg = masses.forearm_kg, masses.upper_arm_kg
    own = (upper_kg + rod_kg) / 3.0 * linkage.upper_arm_m**2
    cross = np.swapaxes(elbows, -1, -2) @ platform
    shared = np.swapaxes(platform, -1, -2) @ platform
    matrix: FloatArray = (
        own[..., None] * np.eye(ARMS)
        + rod_kg / 6.0 * (cross + np.swapaxes(cross, -1, -2))
        + (masses.platform_kg + payload_kg + rod_kg) * shared
    )
    return matrix


def velocity_torque_nm(
    linkage: Linkage,
    masses: Masses,
    angles_rad: FloatArray,
    position_m: FloatArray,
    speeds_radps: FloatArray,
    payload_kg: float = 0.0,
) -> FloatArray:
    """c, the torque that speeds (..., 3) ask for without any acceleration, shape (..., 3) [N m]."""
    elbows = _elbow_slopes_m(linkage, angles_rad)
    platform = jacobian(linkage, angles_rad, position_m)
    elbow_bias = -_arms_m(linkage, angles_rad) * speeds_radps[..., None, :] ** 2
    platform_mps = (platform @ speeds_radps[..., None])[..., 0]
    forearm_m = position_m[..., :, None] - _elbows_m(linkage, angles_rad)
    turning = platform_mps[..., :, None] - elbows * speeds_radps[..., None, :]
    # The forearm's length: f . (p'' - e'') + |p' - e'|^2 = 0 for each arm.
    asked = (forearm_m * elbow_bias).sum(axis=-2) - (turning**2).sum(axis=-2)
    platform_bias = np.linalg.solve(np.swapaxes(forearm_m, -1, -2), asked[..., None])
    rod_kg = masses.forearm_kg
    hung_kg = masses.platform_kg + payload_kg + rod_kg
    to_joints = np.swapaxes(platform, -1, -2)
    rods = np.einsum("...xi,...xi->...i", elbows, elbow_bias) * rod_kg / 3.0
    rods += (np.swapaxes(elbows, -1, -2) @ platform_bias)[..., 0] * rod_kg / 6.0
    rods += (to_joints @ elbow_bias.sum(axis=-1)[..., None])[..., 0] * rod_kg / 6.0
    torque: FloatArray = rods + hung_kg * (to_joints @ platform_bias)[..., 0]
    return torque


def kinetic_energy_j(matrix_kgm2: FloatArray, speeds_radps: FloatArray) -> FloatArray:
    """Energy of motion at speeds (..., 3), shape (...) [J]."""
    energy: FloatArray = 0.5 * np.einsum(
        "...i,...ij,...j->...", speeds_radps, matrix_kgm2, speeds_radps
    )
    return energy


def potential_energy_j(
    linkage: Linkage,
    masses: Masses,
    angles_rad: FloatArray,
    position_m: FloatArray,
    payload_kg: float = 0.0,
) -> FloatArray:
    """Energy of height at poses (..., 3), 0 in the plane of the motor axes, shape (...) [J]."""
    at_elbow_kg = 0.5 * (masses.upper_arm_kg + masses.forearm_kg)
    hung_kg = masses.platform_kg + payload_kg + 0.5 * ARMS * masses.forearm_kg
    elbows_m = _elbows_m(linkage, angles_rad)[..., 2, :].sum(axis=-1)
    energy: FloatArray = STANDARD_GRAVITY_MPS2 * (
        at_elbow_kg * elbows_m + hung_kg * position_m[..., 2]
    )
    return energy


def _arms_m(linkage: Linkage, angles_rad: FloatArray) -> FloatArray:
    """Upper arms as vectors from shaft to elbow, (..., 3, 3): row = x, y, z, column = arm."""
    true_rad = np.asarray(angles_rad, dtype=np.float64) + linkage.home_offset_rad
    level, down = np.cos(true_rad), np.sin(true_rad)
    directions = [level * np.cos(linkage.azimuth_rad), level * np.sin(linkage.azimuth_rad), -down]
    arms: FloatArray = np.stack(directions, axis=-2) * linkage.upper_arm_m
    return arms


def _elbows_m(linkage: Linkage, angles_rad: FloatArray) -> FloatArray:
    """Elbows less the platform's radius, (..., 3, 3): row = x, y, z, column = arm."""
    azimuth = linkage.azimuth_rad
    out = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=-2)
    elbows: FloatArray = _arms_m(linkage, angles_rad) + out * linkage.radius_m
    return elbows


def _elbow_slopes_m(linkage: Linkage, angles_rad: FloatArray) -> FloatArray:
    """d elbow / d its angle [m/rad], (..., 3, 3): row = x, y, z, column = arm."""
    true_rad = np.asarray(angles_rad, dtype=np.float64) + linkage.home_offset_rad
    level, down = np.cos(true_rad), np.sin(true_rad)
    directions = [-down * np.cos(linkage.azimuth_rad), -down * np.sin(linkage.azimuth_rad), -level]
    slopes: FloatArray = np.stack(directions, axis=-2) * linkage.upper_arm_m
    return slopes
