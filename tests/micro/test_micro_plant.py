"""The micro delta in MuJoCo: closed loops, energy, friction that holds, and a second opinion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the micro delta needs the extra 'proof' (MuJoCo)")

from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.dynamics import DeltaPlant, PlantSettings
from deltactl.models.robot_files import load_delta
from deltactl.models.servo_drive import ServoDrive
from deltactl.proof.micro.as_built import Drives, MicroDelta, each
from deltactl.proof.micro.bodies import Rods
from deltactl.proof.micro.checks import START_RAD, check, frictionless
from deltactl.proof.micro.plant import MicroPlant

ROBOT = Path("config/uzunovic-2013.yaml")


@pytest.mark.parametrize("rods", list(Rods))
def test_loops_stay_closed_and_energy_is_kept(rods: Rods) -> None:
    found = check(rods)
    assert found.gap_m < 2e-6
    assert found.energy_share < 0.002


@pytest.mark.study
def test_a_finer_step_closes_the_loops_better() -> None:
    assert check(Rods.BODIES, 2e-5).gap_m < 0.2 * check(Rods.BODIES).gap_m


def test_the_robot_file_describes_this_robot() -> None:
    robot, built = load_delta(ROBOT), MicroDelta()
    drive, drives, body = robot.drive, built.drives, built.body
    assert isinstance(drive, ServoDrive)
    assert robot.masses is not None
    assert robot.geometry.radius_m == pytest.approx(body.base_radius_m - body.platform_radius_m)
    assert robot.geometry.upper_arm_m == body.upper_arm_m
    assert robot.geometry.forearm_m == body.forearm_m
    masses = (body.upper_arm_kg, body.forearm_kg, body.platform_kg)
    assert masses == (
        robot.masses.upper_arm_kg,
        robot.masses.forearm_kg,
        robot.masses.platform_kg,
    )
    assert drives.gear_ratio == drive.gear_ratio
    assert drives.rotor_inertia_kgm2 == each(drive.rotor_inertia_kgm2)
    assert drives.torque_constant_nmpa == each(drive.torque_constant_nmpa)
    assert drives.current_limit_a == drive.current_limit_a
    assert drives.encoder_rad == pytest.approx(drive.rad_per_count)
    assert drives.dry_nm() == pytest.approx(drive.gear_ratio * drive.coulomb_nm)
    assert drives.drag_nmsprad() == pytest.approx(drive.gear_ratio**2 * drive.viscous_nmsprad)


def _fall(seconds: float, period_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Both simulations of the same free fall."""
    robot = load_delta(ROBOT)
    assert isinstance(robot.drive, ServoDrive)
    assert robot.masses is not None
    settings = replace(
        PlantSettings.of(robot.geometry, robot.masses, robot.drive),
        coulomb_nm=each(0.0),
        viscous_nmsprad=each(0.0),
        period_s=period_s,
    )
    theirs = DeltaPlant(settings, START_RAD)
    ours = MicroPlant(frictionless(MicroDelta()), START_RAD, Rods.BODIES, period_s, dry=False)
    for _ in range(round(seconds / period_s)):
        theirs.advance(0.0, 0.0, 0.0)
        ours.advance(0.0, 0.0, 0.0)
    return np.array(theirs.angles_rad()), np.array(ours.angles_rad())


def test_it_falls_as_equation_3_says() -> None:
    theirs, ours = _fall(0.1, 2e-5)
    fallen = theirs - np.array(START_RAD)
    assert fallen.min() > 0.5
    assert np.abs(ours - theirs).max() < 5e-4


def test_dry_friction_above_gravity_holds_the_arms() -> None:
    drives = replace(Drives(), bearing_coulomb_nm=each(0.01))
    plant = MicroPlant(MicroDelta(drives=drives), (0.5, 0.5, 0.5))
    for _ in range(2000):
        plant.advance(0.0, 0.0, 0.0)
    assert np.abs(np.array(plant.angles_rad()) - 0.5).max() < 1e-5


def test_encoders_count_whole_steps_of_a_hundredth_of_a_degree() -> None:
    plant = MicroPlant(MicroDelta(), tuple(np.radians([30.0, 30.004, 30.006]).tolist()))
    assert plant.counts() == (3000, 3000, 3001)


def test_current_beyond_the_limit_gives_the_limit() -> None:
    one, other = MicroPlant(MicroDelta(), START_RAD), MicroPlant(MicroDelta(), START_RAD)
    for _ in range(50):
        one.advance(-100.0, 100.0, 0.0)
        other.advance(-0.8, 0.8, 0.0)
    assert one.angles_rad() == other.angles_rad()


def test_a_counterweight_pulls_its_own_arm() -> None:
    body = replace(MicroDelta().body, counterweight_nm=(0.0, 0.004, 0.0))
    plain, heavy = MicroPlant(MicroDelta(), START_RAD), MicroPlant(MicroDelta(body), START_RAD)
    for _ in range(300):
        plain.advance(0.0, 0.0, 0.0)
        heavy.advance(0.0, 0.0, 0.0)
    more = np.array(heavy.angles_rad()) - np.array(plain.angles_rad())
    assert more[1] > 0.005
    assert more[1] > 4.0 * max(abs(more[0]), abs(more[2]))


def test_arms_that_cannot_meet_are_refused() -> None:
    short = MicroDelta(replace(MicroDelta().body, forearm_m=0.03))
    with pytest.raises(UnreachablePoint, match="cannot be assembled"):
        MicroPlant(short, (0.0, 0.0, 0.0))
