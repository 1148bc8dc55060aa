"""The simulated servo delta: against a finer integration, energy, and dry friction that holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from deltactl.models.dynamics import (
    DeltaPlant,
    PlainBody,
    PlantSettings,
    kinetic_energy_j,
    mass_matrix_kgm2,
    potential_energy_j,
)
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import Geometry, Masses

GEOMETRY = Geometry(
    base_radius_m=0.040, platform_radius_m=0.030, upper_arm_m=0.040, forearm_m=0.068
)
MASSES = Masses(upper_arm_kg=0.008, forearm_kg=0.005, platform_kg=0.012)
LINKAGE = Linkage.of(GEOMETRY)
GEAR, ROTOR, TORQUE = 14.0, 5.4e-8, 8e-3
FREE = PlantSettings(
    geometry=GEOMETRY,
    masses=MASSES,
    period_s=1e-4,
    gear_ratio=GEAR,
    rotor_inertia_kgm2=ROTOR,
    torque_constants_nmpa=(TORQUE,) * 3,
    coulomb_nm=(0.0,) * 3,
    viscous_nmsprad=(0.0,) * 3,
)
START = (0.5, 0.6, 0.4)


def energy_j(angles, speeds) -> float:
    """Of everything that moves, rotors too."""
    angles, speeds = np.array(angles), np.array(speeds)
    place = forward(LINKAGE, angles).position_m
    matrix = mass_matrix_kgm2(LINKAGE, MASSES, angles, place) + ROTOR * GEAR**2 * np.eye(3)
    return float(
        kinetic_energy_j(matrix, speeds) + potential_energy_j(LINKAGE, MASSES, angles, place)
    )


def runge_kutta(angles, currents_a, seconds: float, steps: int):
    """Angles and speeds after a time, by the classic fourth-order method."""
    body = PlainBody(LINKAGE, MASSES)
    torque = GEAR * TORQUE * np.array(currents_a)

    def rates(state):
        terms = body.terms(tuple(state[:3]), tuple(state[3:]))
        m11, m22, m33, m12, m13, m23 = terms[:6]
        matrix = np.array([[m11, m12, m13], [m12, m22, m23], [m13, m23, m33]])
        matrix += ROTOR * GEAR**2 * np.eye(3)
        return np.concatenate([state[3:], np.linalg.solve(matrix, torque - terms.load)])

    state, h = np.concatenate([angles, np.zeros(3)]), seconds / steps
    for _ in range(steps):
        k1 = rates(state)
        k2 = rates(state + h / 2 * k1)
        k3 = rates(state + h / 2 * k2)
        k4 = rates(state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state[:3], state[3:]


def test_the_equation_of_motion_keeps_energy() -> None:
    before = energy_j(START, (0.0,) * 3)
    angles, speeds = runge_kutta(START, (0.0,) * 3, 0.08, 400)
    assert np.abs(speeds).max() > 5.0  # it fell
    moved = energy_j(angles, (0.0,) * 3) - before
    assert abs(energy_j(angles, speeds) - before) < 1e-8 * abs(moved)


def test_the_plant_falls_as_a_finer_integration_says() -> None:
    plant = DeltaPlant(FREE, START)
    currents = (0.02, -0.01, 0.03)
    for _ in range(500):
        plant.advance(*currents)
    angles, speeds = runge_kutta(START, currents, 0.05, 500)
    fell = np.abs(angles - START).max()
    assert fell > 0.05
    assert np.abs(np.array(plant.angles_rad()) - angles).max() < 0.01 * fell
    assert np.abs(np.array(plant.speeds_radps()) - speeds).max() < 0.01 * np.abs(speeds).max()


def test_the_plants_error_shrinks_with_its_period() -> None:
    angles, _ = runge_kutta(START, (0.0,) * 3, 0.05, 500)
    errors = []
    for periods in (500, 1000, 2000):
        plant = DeltaPlant(replace(FREE, period_s=0.05 / periods), START)
        for _ in range(periods):
            plant.advance(0.0, 0.0, 0.0)
        errors.append(np.abs(np.array(plant.angles_rad()) - angles).max())
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] < 0.6 * errors[1]


def holding_a(plant: DeltaPlant) -> np.ndarray:
    return np.array(plant.terms().load) / (GEAR * TORQUE)


def test_dry_friction_holds_what_it_can_and_no_more() -> None:
    coulomb_a = 0.03
    settings = replace(FREE, coulomb_nm=(coulomb_a * TORQUE,) * 3)
    for share, moves in ((0.9, False), (1.1, True)):
        plant = DeltaPlant(settings, START)
        push = holding_a(plant) + share * coulomb_a * np.array([1.0, 0.0, 0.0])
        for _ in range(1000):
            plant.advance(*push)
        moved = np.abs(np.array(plant.angles_rad()) - START)
        assert (moved[0] > 0.01) == moves
        if not moves:
            assert moved.max() < 1e-5


def test_friction_takes_what_the_law_says() -> None:
    """All arms driven alike at constant current: speed settles where friction eats the rest."""
    viscous = 2e-7
    settings = replace(FREE, coulomb_nm=(1e-4,) * 3, viscous_nmsprad=(viscous,) * 3)
    plant = DeltaPlant(settings, (0.2, 0.2, 0.2))
    spent = given = 0.0
    before = energy_j(plant.angles_rad(), (0.0,) * 3)
    for _ in range(900):
        speeds = np.array(plant.speeds_radps()) * GEAR
        plant.advance(0.02, 0.02, 0.02)
        after = np.array(plant.speeds_radps()) * GEAR
        middle = (speeds + after) / 2
        given += 1e-4 * TORQUE * 0.02 * after.sum()
        spent += 1e-4 * (1e-4 * np.abs(after).sum() + viscous * (middle**2).sum())
    now = energy_j(plant.angles_rad(), plant.speeds_radps())
    assert spent > 0.1 * given
    assert now - before == pytest.approx(given - spent, abs=0.01 * (given + spent))


def test_the_stops_hold_and_let_go() -> None:
    plant = DeltaPlant(replace(FREE, stops_rad=(0.0, 0.8)), START)
    for _ in range(10_000):
        plant.advance(0.0, 0.0, 0.0)
    assert max(plant.angles_rad()) < 0.8 + 0.01
    for _ in range(300):
        plant.advance(-0.2, -0.2, -0.2)
    assert max(plant.angles_rad()) < 0.7


def test_brakes_hold() -> None:
    plant = DeltaPlant(FREE, START)
    plant.advance(0.5, 0.5, 0.5)
    plant.hold()
    held = plant.angles_rad()
    for _ in range(100):
        plant.hold()
    assert plant.angles_rad() == held
    assert plant.speeds_radps() == (0.0, 0.0, 0.0)


def test_a_linkage_that_would_come_apart_jams() -> None:
    """Arms driven hard against each other: the forearms end in one plane, and no further."""
    wide = GEOMETRY.model_copy(update={"forearm_m": 0.045})
    plant = DeltaPlant(replace(FREE, geometry=wide), (0.9, 0.9, 0.9))
    for _ in range(3000):
        plant.advance(-0.3, -0.3, -0.3)
    reach = forward(Linkage.of(wide), np.array(plant.angles_rad()))
    assert np.isfinite(reach.position_m).all()
    assert max(plant.angles_rad()) < 0.9
    assert min(plant.angles_rad()) > 0.0
