"""The files in models/trained: for the robots in config/, and as good as they say."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deltactl.foundation.errors import LimitExceeded
from deltactl.models.linkage import Linkage
from deltactl.models.network import InverseNetwork
from deltactl.models.network.file import TRAINED_FOLDER
from deltactl.models.robot import DeltaRobot
from deltactl.models.robot_files import load_delta
from deltactl.models.training.export import Effort, errors_deg, worst_deg
from deltactl.models.training.recipe import Task
from deltactl.models.training.samples import around, hardest, labels_rad, spread
from deltactl.models.training.train_shipped import CONFIG_FOLDER, SHIPPED, Shipped

MICROSTEP_DEG = 0.0225
"""Of the Zhao robot: 1600 microsteps a turn, gear 10."""

SEED = 20_231
"""Neither of the training nor of its validation."""


def robot_of(shipped: Shipped) -> DeltaRobot:
    """The robot file's model part."""
    return load_delta(CONFIG_FOLDER / f"{shipped.robot}.yaml")


def path_of(shipped: Shipped) -> Path:
    """The shipped file."""
    return TRAINED_FOLDER / f"{shipped.robot}.tflite"


@pytest.fixture(params=SHIPPED, ids=lambda shipped: shipped.robot)
def shipped(request: pytest.FixtureRequest) -> Shipped:
    return request.param  # type: ignore[no-any-return]


@pytest.fixture
def network(shipped: Shipped) -> InverseNetwork:
    return InverseNetwork.open(path_of(shipped), robot_of(shipped))


def task_of(shipped: Shipped) -> Task:
    """What was trained."""
    return Task(robot_of(shipped), shipped.domain, shipped.seed, shipped.angle_deg)


def even_errors_deg(network: InverseNetwork, shipped: Shipped) -> Any:
    """Running network minus float64 geometry on fresh points of the domain."""
    task, linkage = task_of(shipped), Linkage.of(robot_of(shipped).geometry)
    position_m = spread(shipped.domain, np.random.default_rng(SEED), 20_000)
    return errors_deg(network, linkage, task, position_m)


def test_every_shipped_file_is_listed_and_every_listed_file_ships() -> None:
    files = {path.stem for path in TRAINED_FOLDER.glob("*.tflite")}
    assert files == {shipped.robot for shipped in SHIPPED}


def test_the_file_says_how_to_make_it_again(network: InverseNetwork, shipped: Shipped) -> None:
    metadata = network.metadata
    assert metadata.domain == shipped.domain
    assert metadata.angle_deg == shipped.angle_deg
    assert metadata.training.seed == shipped.seed
    assert metadata.training.settings == shipped.settings.as_metadata()


@pytest.mark.study
def test_its_bound_holds_wherever_it_answers(network: InverseNetwork, shipped: Shipped) -> None:
    stated = network.metadata.validation
    even_deg = even_errors_deg(network, shipped)
    assert np.abs(even_deg).max() <= stated.bound_deg
    assert np.sqrt(np.mean(even_deg**2)) == pytest.approx(stated.rmse_deg, rel=0.1)
    # A search that climbs from other starts; and the bound is not merely a large number.
    search = np.random.default_rng(SEED), Effort(samples=20_000, rounds=25)
    worst = worst_deg(network, task_of(shipped), *search)
    assert 0.5 * stated.bound_deg <= worst <= stated.bound_deg


def test_the_zhao_network_is_right_to_a_microstep_in_the_working_cylinder() -> None:
    zhao = SHIPPED[0]
    network = InverseNetwork.open(path_of(zhao), robot_of(zhao))
    assert network.metadata.parameters <= 400
    assert np.sqrt(np.mean(even_errors_deg(network, zhao) ** 2)) <= 0.001
    # That the bound holds is the test before this one.
    assert network.metadata.validation.bound_deg <= MICROSTEP_DEG


def test_what_the_zhao_network_refuses_of_its_cylinder_is_a_sliver_at_the_rim() -> None:
    zhao = SHIPPED[0]
    linkage = Linkage.of(robot_of(zhao).geometry)
    rng = np.random.default_rng(SEED)
    anchor_m = hardest(zhao.domain, linkage, rng)
    near_m = around(zhao.domain, anchor_m, rng, 50_000, finest_m=1e-8)
    angles_rad = labels_rad(linkage, near_m)
    refused_m = near_m[(angles_rad > np.deg2rad(zhao.angle_deg[1])).any(axis=1)]
    assert len(refused_m) > 100
    radius_m = np.hypot(refused_m[:, 0], refused_m[:, 1])
    assert radius_m.min() > 0.2 - 2e-5
    assert refused_m[:, 2].max() < -0.6 + 2e-5
    # The robot's own arm limit refuses far more than that.
    assert zhao.angle_deg[1] > 110.0


@pytest.mark.study
def test_float32_costs_next_to_nothing(
    network: InverseNetwork, shipped: Shipped, in_float64: Callable[[bytes, Any], Any]
) -> None:
    position_m = spread(shipped.domain, np.random.default_rng(SEED), 300)
    exact_rad = [in_float64(network.file.content, target[None])[0] for target in position_m]
    difference_deg = np.rad2deg(network.raw_rad_many(position_m) - np.array(exact_rad))
    assert np.sqrt(np.mean(difference_deg**2)) < 0.01 * MICROSTEP_DEG
    assert np.abs(difference_deg).max() < 0.1 * MICROSTEP_DEG


def test_the_jobs_of_the_paper_are_inside() -> None:
    zhao = SHIPPED[0]
    network = InverseNetwork.open(path_of(zhao), robot_of(zhao))
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle_m = np.stack([0.15 * np.cos(turn), 0.15 * np.sin(turn), np.full(200, -0.45)], axis=1)
    assert np.isfinite(network.angles_rad_many(circle_m)).all()


def test_no_target_outside_is_answered(network: InverseNetwork, shipped: Shipped) -> None:
    low_m, high_m = shipped.domain.bounding_box()
    centre_m = 0.5 * (low_m + high_m)
    for axis in range(3):
        for edge_m in (low_m, high_m):
            outside_m = centre_m.copy()
            outside_m[axis] = edge_m[axis] + 1e-4 * np.sign(edge_m[axis] - centre_m[axis])
            with pytest.raises(LimitExceeded, match="was trained for"):
                network.angles_rad(*outside_m.tolist())
