"""Targets to checked step counts, the same for geometry and network, for one and for many."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.foundation.errors import LimitExceeded, UnreachablePoint
from deltactl.models.inverse_kinematics import GeometricInverse, InverseKinematics, TargetMapper
from deltactl.models.linkage import Linkage, forward
from deltactl.models.network import Cylinder, InverseNetwork
from deltactl.models.robot import DeltaRobot, Drive, Geometry
from deltactl.models.training import arm_networks
from deltactl.models.training.export import Effort, to_file
from deltactl.models.training.recipe import Settings, Task

DRIVE = Drive(microsteps_per_rev=1600, gear_ratio=10.0)
LIMITS_DEG = (-20.0, 110.0)
GEOMETRY = Geometry(base_radius_m=0.325, platform_radius_m=0.075, upper_arm_m=0.25, forearm_m=0.5)
angle = st.floats(min_value=math.radians(20.0), max_value=math.radians(90.0))


class Fixed:
    """Inverse kinematics that always answers the same angles."""

    def __init__(self, *angles_deg: float):
        first, second, third = (math.radians(angle_deg) for angle_deg in angles_deg)
        self.angles = first, second, third

    def angles_rad(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
        return self.angles

    def angles_rad_many(self, position_m: Any) -> Any:
        return np.tile(self.angles, (len(position_m), 1))


@pytest.fixture(scope="module")
def network(tmp_path_factory: pytest.TempPathFactory) -> InverseNetwork:
    """A barely trained network: what it is asked matters here, not how good it is."""
    robot = DeltaRobot(kind="delta", name="bench", geometry=GEOMETRY)
    task = Task(robot, Cylinder(radius_m=0.15, z_m=(-0.55, -0.4)), seed=0)
    settings = Settings(hidden=(6,), spread=150, edge=50, cluster=50, iterations=50, rounds=0)
    path = tmp_path_factory.mktemp("network") / "bench.tflite"
    return InverseNetwork(to_file(path, arm_networks.train(task, settings), task, Effort(2000, 5)))


@pytest.fixture(params=["geometry", "network"])
def kinematics(request: pytest.FixtureRequest, network: InverseNetwork) -> InverseKinematics:
    """Both implementations of the contract."""
    return GeometricInverse(GEOMETRY) if request.param == "geometry" else network


def targets(count: int) -> Any:
    rng = np.random.default_rng(9)
    radius_m, turn = 0.15 * np.sqrt(rng.uniform(size=count)), rng.uniform(0.0, 6.3, count)
    z_m = rng.uniform(-0.55, -0.4, count)
    return np.stack([radius_m * np.cos(turn), radius_m * np.sin(turn), z_m], axis=1)


def test_one_and_many_give_the_same_numbers(kinematics: InverseKinematics) -> None:
    position_m = targets(2000)
    mapper = TargetMapper(kinematics, DRIVE, LIMITS_DEG)
    many_rad = kinematics.angles_rad_many(position_m)
    for angles_rad, target in zip(many_rad.tolist(), position_m.tolist(), strict=True):
        assert tuple(angles_rad) == kinematics.angles_rad(*target)
        assert mapper.counts(*target) == tuple(round(a / DRIVE.rad_per_step) for a in angles_rad)


def test_counts_are_plain_integers(kinematics: InverseKinematics) -> None:
    counts = TargetMapper(kinematics, DRIVE, LIMITS_DEG).counts(0.05, 0.02, -0.45)
    assert [type(count) for count in counts] == [int, int, int]


def test_nothing_in_nothing_out(kinematics: InverseKinematics) -> None:
    assert kinematics.angles_rad_many(np.empty((0, 3))).shape == (0, 3)


def test_network_and_geometry_agree_to_the_networks_error(network: InverseNetwork) -> None:
    position_m = targets(500)
    error_deg = np.rad2deg(
        network.angles_rad_many(position_m) - GeometricInverse(GEOMETRY).angles_rad_many(position_m)
    )
    assert np.abs(error_deg).max() <= network.metadata.validation.bound_deg


@given(angle, angle, angle)
def test_counts_of_a_pose_are_its_angles_to_half_a_microstep(
    first: float, second: float, third: float
) -> None:
    angles_rad = np.array([first, second, third])
    position_m = forward(Linkage.of(GEOMETRY), angles_rad).position_m
    mapper = TargetMapper(GeometricInverse(GEOMETRY), DRIVE, LIMITS_DEG)
    counts = mapper.counts(*position_m.tolist())
    back_rad = np.array(counts) * DRIVE.rad_per_step
    assert np.abs(back_rad - angles_rad).max() <= (0.5 + 1e-6) * DRIVE.rad_per_step


@pytest.mark.parametrize(("angle_deg", "count"), [(0.0, 0), (0.0225, 1), (-9.0, -400), (110, 4889)])
def test_counts_are_angles_over_the_microstep(angle_deg: float, count: int) -> None:
    mapper = TargetMapper(Fixed(angle_deg, 0.0, 0.0), DRIVE, LIMITS_DEG)
    assert mapper.counts(0.0, 0.0, 0.0) == (count, 0, 0)


@pytest.mark.parametrize("arm", [1, 2, 3])
@pytest.mark.parametrize("angle_deg", [-20.1, 110.1, 126.0])
def test_an_arm_beyond_its_limit_is_refused_by_name(arm: int, angle_deg: float) -> None:
    angles_deg = [10.0, 20.0, 30.0]
    angles_deg[arm - 1] = angle_deg
    mapper = TargetMapper(Fixed(*angles_deg), DRIVE, LIMITS_DEG)
    wanted = rf"target \(0\.1000, 0\.2000, -0\.3000\) m: arm {arm} would be at {angle_deg:.0f}"
    with pytest.raises(LimitExceeded, match=wanted):
        mapper.counts(0.1, 0.2, -0.3)


def test_the_limits_themselves_are_allowed() -> None:
    mapper = TargetMapper(Fixed(-20.0, 110.0, 0.0), DRIVE, LIMITS_DEG)
    low, high, _ = mapper.counts(0.0, 0.0, 0.0)
    assert abs(low * DRIVE.rad_per_step - math.radians(-20.0)) <= 0.5 * DRIVE.rad_per_step
    assert abs(high * DRIVE.rad_per_step - math.radians(110.0)) <= 0.5 * DRIVE.rad_per_step


def test_a_point_that_cannot_be_reached_is_refused() -> None:
    mapper = TargetMapper(GeometricInverse(GEOMETRY), DRIVE, LIMITS_DEG)
    with pytest.raises(UnreachablePoint):
        mapper.counts(0.5, 0.5, -0.6)
