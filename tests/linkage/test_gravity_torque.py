"""Gravity torque against the slope of the potential energy, and against cases known by hand."""

from __future__ import annotations

import numpy as np
import pytest

from deltactl.models.gravity import STANDARD_GRAVITY_MPS2, gravity_torque_nm
from deltactl.models.linkage import Linkage, forward, parallel_margin, serial_margin
from deltactl.models.robot import FloatArray, Masses

MASSES = Masses(upper_arm_kg=0.205, forearm_kg=0.153, platform_kg=0.653)
STEP_RAD = 2e-4


def energy_j(linkage: Linkage, angles_rad: FloatArray, payload_kg: float) -> FloatArray:
    """Potential energy of every body at its own centre, forearm rods included; shape (...)."""
    platform_z_m = forward(linkage, angles_rad).position_m[..., 2]
    elbow_z_m = -linkage.upper_arm_m * np.sin(angles_rad + linkage.home_offset_rad)
    moment = (MASSES.platform_kg + payload_kg) * platform_z_m
    for arm in range(3):
        moment = moment + MASSES.upper_arm_kg * elbow_z_m[..., arm] / 2.0
        moment = moment + MASSES.forearm_kg * (elbow_z_m[..., arm] + platform_z_m) / 2.0
    return STANDARD_GRAVITY_MPS2 * moment


@pytest.mark.parametrize("payload_kg", [0.0, 0.5])
def test_torque_is_minus_the_slope_of_the_energy(linkage: Linkage, payload_kg: float) -> None:
    angles_rad = np.deg2rad(np.random.default_rng(51).uniform(-20.0, 110.0, (3000, 3)))
    position_m, status = forward(linkage, angles_rad)
    keep = (status == 0) & (parallel_margin(linkage, angles_rad, position_m) > 0.05)
    keep &= np.abs(serial_margin(linkage, angles_rad, position_m)).min(axis=-1) > 0.05
    angles_rad, position_m = angles_rad[keep], position_m[keep]
    assert len(angles_rad) > 1000
    torque_nm = gravity_torque_nm(linkage, MASSES, angles_rad, position_m, payload_kg)
    for arm in range(3):
        step = np.zeros(3)
        step[arm] = STEP_RAD
        near = energy_j(linkage, angles_rad + step, payload_kg)
        near = near - energy_j(linkage, angles_rad - step, payload_kg)
        far = energy_j(linkage, angles_rad + 2 * step, payload_kg)
        far = far - energy_j(linkage, angles_rad - 2 * step, payload_kg)
        slope_nm = (8.0 * near - far) / (12.0 * STEP_RAD)
        scale_nm = STANDARD_GRAVITY_MPS2 * 2.0 * float(linkage.upper_arm_m.max())
        assert np.abs(torque_nm[:, arm] + slope_nm).max() < 1e-7 * scale_nm


def test_level_arms_carry_their_own_half_and_a_third_of_the_rest() -> None:
    """Arms level, forearms straight down: no lever but the upper arm."""
    linkage = Linkage(
        radius_m=np.full(3, -0.25 + 1e-3),
        upper_arm_m=np.full(3, 0.25),
        forearm_m=np.full(3, 0.5),
        azimuth_rad=np.deg2rad([0.0, 120.0, 240.0]),
        home_offset_rad=np.zeros(3),
    )
    angles_rad = np.zeros(3)
    torque_nm = gravity_torque_nm(linkage, MASSES, angles_rad, forward(linkage, angles_rad)[0])
    own_kg = 0.205 / 2.0 + 0.153 / 2.0
    third_kg = (0.653 + 1.5 * 0.153) / 3.0
    np.testing.assert_allclose(torque_nm, 9.80665 * 0.25 * (own_kg + third_kg), rtol=1e-9)


def test_gravity_pulls_down_and_a_payload_adds_its_share(zhao: Linkage) -> None:
    angles_rad = np.deg2rad([[30.0, 30.0, 30.0], [50.0, 45.0, 40.0]])
    position_m = forward(zhao, angles_rad).position_m
    empty_nm = gravity_torque_nm(zhao, MASSES, angles_rad, position_m)
    assert (empty_nm > 0.0).all()
    one_nm = gravity_torque_nm(zhao, MASSES, angles_rad, position_m, 1.0) - empty_nm
    both_nm = gravity_torque_nm(zhao, MASSES, angles_rad, position_m, np.array([1.0, 2.0]))
    np.testing.assert_allclose(both_nm - empty_nm, one_nm * [[1.0], [2.0]], rtol=1e-12)


def test_unreachable_poses_have_no_torque(zhao: Linkage) -> None:
    lost = np.full((2, 3), np.nan)
    assert np.isnan(gravity_torque_nm(zhao, MASSES, lost, lost)).all()
