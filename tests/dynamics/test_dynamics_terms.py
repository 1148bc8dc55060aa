"""The equation of motion against Lagrange's recipe, done numerically on rods cut into points."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.models.dynamics import (
    PlainBody,
    kinetic_energy_j,
    mass_matrix_kgm2,
    potential_energy_j,
    velocity_torque_nm,
)
from deltactl.models.gravity import gravity_torque_nm
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import FloatArray, Geometry, Masses

GEOMETRY = Geometry(
    base_radius_m=0.040, platform_radius_m=0.030, upper_arm_m=0.040, forearm_m=0.068
)
MASSES = Masses(upper_arm_kg=0.008, forearm_kg=0.005, platform_kg=0.012)
angle, speed = st.floats(-0.2, 1.3), st.floats(-20.0, 20.0)
poses = st.tuples(angle, angle, angle)
speeds = st.tuples(speed, speed, speed)
LINKAGE = Linkage.of(GEOMETRY)
NUDGE = 1e-5
PAYLOAD_KG = 0.003


def position(angles: FloatArray) -> FloatArray:
    return forward(LINKAGE, angles).position_m


def matrix(angles: FloatArray) -> FloatArray:
    return mass_matrix_kgm2(LINKAGE, MASSES, angles, position(angles), PAYLOAD_KG)


def by_angle(function, angles: FloatArray) -> FloatArray:
    """Derivatives by the three angles, the last dimension being the angle."""
    parts = []
    for arm in range(3):
        step = NUDGE * np.eye(3)[arm]
        parts.append((function(angles + step) - function(angles - step)) / (2 * NUDGE))
    return np.stack(parts, axis=-1)


def points_of_mass(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Masses and places of a robot made of points: rods by Gauss and Legendre's three."""
    places, masses = [position(angles)], [MASSES.platform_kg + PAYLOAD_KG]
    nodes, weights = np.polynomial.legendre.leggauss(3)
    azimuth = LINKAGE.azimuth_rad
    for arm in range(3):
        out = np.array([np.cos(azimuth[arm]), np.sin(azimuth[arm]), 0.0])
        shaft = LINKAGE.radius_m[arm] * out
        level, down = np.cos(angles[arm]), np.sin(angles[arm])
        elbow = shaft + LINKAGE.upper_arm_m[arm] * (level * out - down * np.array([0, 0, 1.0]))
        for ends, rod_kg in (
            ((shaft, elbow), MASSES.upper_arm_kg),
            ((elbow, places[0]), MASSES.forearm_kg),
        ):
            for node, weight in zip(nodes, weights, strict=True):
                places.append(ends[0] + (ends[1] - ends[0]) * (node + 1) / 2)
                masses.append(rod_kg * weight / 2)
    return np.array(masses), np.array(places)


@given(poses, speeds)
@settings(max_examples=25, deadline=None)
def test_kinetic_energy_is_that_of_points_in_motion(pose, moving) -> None:
    angles, rates = np.array(pose), np.array(moving)
    masses, _ = points_of_mass(angles)
    velocity = by_angle(lambda a: points_of_mass(a)[1], angles) @ rates
    energy = 0.5 * (masses[:, None] * velocity**2).sum()
    assert np.isclose(kinetic_energy_j(matrix(angles), rates), energy, rtol=1e-6, atol=1e-15)


@given(poses)
@settings(max_examples=25, deadline=None)
def test_gravity_is_the_slope_of_height(pose) -> None:
    angles = np.array(pose)
    masses, places = points_of_mass(angles)
    height = potential_energy_j(LINKAGE, MASSES, angles, position(angles), PAYLOAD_KG)
    assert np.isclose(height, 9.80665 * masses @ places[:, 2], rtol=1e-9)
    slope = by_angle(
        lambda a: potential_energy_j(LINKAGE, MASSES, a, position(a), PAYLOAD_KG), angles
    )
    torque = gravity_torque_nm(LINKAGE, MASSES, angles, position(angles), PAYLOAD_KG)
    assert np.allclose(-slope, torque, rtol=1e-6, atol=1e-10)


@given(poses, speeds)
@settings(max_examples=25, deadline=None)
def test_velocity_torque_is_lagranges(pose, moving) -> None:
    angles, rates = np.array(pose), np.array(moving)
    slopes = by_angle(matrix, angles)  # dM_ij / da_k
    expected = np.einsum("ijk,j,k->i", slopes, rates, rates)
    expected -= 0.5 * np.einsum("jki,j,k->i", slopes, rates, rates)
    found = velocity_torque_nm(LINKAGE, MASSES, angles, position(angles), rates, PAYLOAD_KG)
    assert np.allclose(found, expected, rtol=1e-4, atol=1e-9 * (1 + (rates**2).sum()))


@given(poses, speeds, st.floats(0.0, 0.01))
@settings(max_examples=40, deadline=None)
def test_plain_floats_say_the_same(pose, moving, payload_kg) -> None:
    angles, rates = np.array(pose), np.array(moving)
    place = position(angles)
    terms = PlainBody(LINKAGE, MASSES, payload_kg).terms(pose, moving)
    whole = mass_matrix_kgm2(LINKAGE, MASSES, angles, place, payload_kg)
    entries = [whole[0, 0], whole[1, 1], whole[2, 2], whole[0, 1], whole[0, 2], whole[1, 2]]
    assert np.allclose(terms[:6], entries, rtol=1e-9, atol=1e-15)
    load = velocity_torque_nm(LINKAGE, MASSES, angles, place, rates, payload_kg)
    load -= gravity_torque_nm(LINKAGE, MASSES, angles, place, payload_kg)
    assert np.allclose(terms.load, load, rtol=1e-9, atol=1e-12)


def test_many_poses_at_once() -> None:
    angles = np.random.default_rng(1).uniform(0.0, 1.0, (5, 4, 3))
    many = matrix(angles)
    assert many.shape == (5, 4, 3, 3)
    assert np.array_equal(many[3, 2], matrix(angles[3, 2]))
    assert (np.linalg.eigvalsh(many) > 0.0).all()
