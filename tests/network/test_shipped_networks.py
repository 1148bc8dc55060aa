"""The files in models/trained: for the robots in config/, and as good as they say."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from foundation.errors import LimitExceeded
from models.linkage import Linkage
from models.network import InverseNetwork
from models.network.file import TRAINED_FOLDER
from models.robot import DeltaRobot, load_delta
from models.training.samples import around, edges, hardest, labels_rad, spread
from models.training.train_shipped import CONFIG_FOLDER, SHIPPED, Shipped

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


def errors_deg(network: InverseNetwork, shipped: Shipped, position_m: Any) -> Any:
    """Running network minus float64 geometry, where the network answers."""
    wanted_rad = labels_rad(Linkage.of(robot_of(shipped).geometry), position_m)
    highest_rad = np.deg2rad(network.metadata.angle_deg[1])
    learned = (wanted_rad <= highest_rad).all(axis=1)
    return np.rad2deg(network.raw_rad_many(position_m[learned]) - wanted_rad[learned])


def hard_points(shipped: Shipped, rng: np.random.Generator) -> Any:
    """Faces and edges of the domain, and ever closer to its hardest point."""
    linkage = Linkage.of(robot_of(shipped).geometry)
    anchor_m = hardest(shipped.domain, linkage, rng)
    near_m = around(shipped.domain, anchor_m, rng, 10_000, finest_m=1e-8)
    return np.vstack([edges(shipped.domain, rng, 10_000), near_m])


def test_every_shipped_file_is_listed_and_every_listed_file_ships() -> None:
    files = {path.stem for path in TRAINED_FOLDER.glob("*.tflite")}
    assert files == {shipped.robot for shipped in SHIPPED}


def test_the_file_says_how_to_make_it_again(network: InverseNetwork, shipped: Shipped) -> None:
    metadata = network.metadata
    assert metadata.domain == shipped.domain
    assert metadata.angle_deg == shipped.angle_deg
    assert metadata.training.seed == shipped.seed
    assert metadata.training.settings == shipped.settings.as_metadata()


def test_its_bound_holds_everywhere_it_answers(network: InverseNetwork, shipped: Shipped) -> None:
    rng = np.random.default_rng(SEED)
    stated = network.metadata.validation
    even_deg = errors_deg(network, shipped, spread(shipped.domain, rng, 20_000))
    hard_deg = errors_deg(network, shipped, hard_points(shipped, rng))
    assert np.abs(even_deg).max() <= stated.bound_deg
    # Sampling finds the largest error only to a few per cent.
    assert np.abs(hard_deg).max() <= 1.05 * stated.bound_deg
    assert np.sqrt(np.mean(even_deg**2)) == pytest.approx(stated.rmse_deg, rel=0.1)


def test_the_zhao_network_is_right_to_a_microstep_in_the_working_cylinder() -> None:
    zhao = SHIPPED[0]
    network, rng = InverseNetwork.open(path_of(zhao), robot_of(zhao)), np.random.default_rng(SEED)
    assert network.metadata.parameters <= 400
    even_deg = errors_deg(network, zhao, spread(zhao.domain, rng, 20_000))
    assert np.sqrt(np.mean(even_deg**2)) <= 0.001
    hard_deg = errors_deg(network, zhao, hard_points(zhao, rng))
    assert max(np.abs(even_deg).max(), np.abs(hard_deg).max()) <= MICROSTEP_DEG


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


def test_float32_costs_next_to_nothing(
    network: InverseNetwork, shipped: Shipped, in_float64: Callable[[bytes, Any], Any]
) -> None:
    position_m = spread(shipped.domain, np.random.default_rng(SEED), 2000)
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
