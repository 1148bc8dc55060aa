"""A shortened training of our own recipe, and what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deltactl.foundation.errors import NetworkError
from deltactl.models.linkage import Linkage, serial_margin
from deltactl.models.network import Cylinder, InverseNetwork, NetworkFile
from deltactl.models.robot import DeltaRobot
from deltactl.models.training import arm_networks
from deltactl.models.training.export import Effort, measure, to_file
from deltactl.models.training.recipe import Settings, Task
from deltactl.models.training.samples import around, edges, hardest, labels_rad, spread

SHORT = Settings(
    hidden=(6,), spread=150, edge=50, cluster=100, iterations=60, rounds=1, iterations_a_round=20
)
QUICK = Effort(samples=2000, rounds=5)
CYLINDER = Cylinder(radius_m=0.2, z_m=(-0.6, -0.35))


@pytest.fixture
def short(task: Task, tmp_path: Path) -> NetworkFile:
    return to_file(tmp_path / "short.tflite", arm_networks.train(task, SHORT), task, QUICK)


def test_a_short_training_already_knows_the_robot(short: NetworkFile, task: Task) -> None:
    reread = NetworkFile.load(short.path)
    assert reread == short
    assert reread.metadata.validation.rmse_deg < 0.05
    assert reread.metadata.architecture == "3-6-1 tanh, shared by three arms"
    assert reread.metadata.training.settings["iterations"] == 60
    assert not list(short.path.parent.glob(".*.part"))


@pytest.mark.study
def test_the_same_seed_gives_the_same_file(short: NetworkFile, task: Task) -> None:
    again = to_file(short.path, arm_networks.train(task, SHORT), task, QUICK)
    assert again.content == short.content
    other = replace(task, seed=task.seed + 1)
    assert (
        to_file(short.path, arm_networks.train(other, SHORT), other, QUICK).content != short.content
    )


@pytest.mark.study
def test_the_stated_errors_are_those_of_the_running_network(short: NetworkFile, task: Task) -> None:
    stated = short.metadata.validation
    assert measure(short, task, QUICK) == stated.model_copy(update={"parity_deg": None})
    assert 0.0 < stated.parity_deg < 1e-3
    rng = np.random.default_rng(77)
    position_m = spread(task.domain, rng, 2000)
    wanted_rad = labels_rad(Linkage.of(task.robot.geometry), position_m)
    error_deg = np.rad2deg(InverseNetwork(short).angles_rad_many(position_m) - wanted_rad)
    assert np.abs(error_deg).max() <= short.metadata.validation.bound_deg
    assert np.sqrt(np.mean(error_deg**2)) == pytest.approx(
        short.metadata.validation.rmse_deg, rel=0.1
    )


def test_progress_is_told_stage_by_stage(task: Task) -> None:
    lines: list[str] = []
    arm_networks.train(task, replace(SHORT, iterations=3, iterations_a_round=2), lines.append)
    assert len(lines) == 2
    assert "stage 1 of 1" in lines[1]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"upper_arm_m": (0.25, 0.25, 0.26)}, "upper_arm_m"),
        ({"home_offset_deg": (0.1, 0.0, 0.0)}, "home_offset_rad"),
    ],
)
def test_arms_that_differ_are_refused(
    make_robot: Callable[..., DeltaRobot], task: Task, change: dict[str, object], field: str
) -> None:
    with pytest.raises(NetworkError, match=rf"arms differ \({field}\)"):
        arm_networks.train(replace(task, robot=make_robot(**change)), SHORT)


@pytest.mark.study
def test_turned_robots_with_an_equal_home_offset_are_learned(
    make_robot: Callable[..., DeltaRobot], task: Task, tmp_path: Path
) -> None:
    turned = make_robot(azimuth_deg=(30.0, 150.0, 270.0), home_offset_deg=(0.5, 0.5, 0.5))
    changed = replace(task, robot=turned)
    file = to_file(tmp_path / "turned.tflite", arm_networks.train(changed, SHORT), changed, QUICK)
    assert file.metadata.validation.rmse_deg < 0.05


def test_a_domain_off_the_workspace_is_refused(task: Task) -> None:
    far = replace(task, domain=Cylinder(radius_m=0.3, z_m=(-0.7, -0.35)))
    with pytest.raises(NetworkError, match="cannot be reached; make the domain smaller"):
        arm_networks.train(far, SHORT)


def test_the_graph_sees_every_arm_from_its_own_motor(make_robot: Callable[..., DeltaRobot]) -> None:
    linkage = Linkage.of(make_robot().geometry)
    rows = arm_networks.arm_rows(linkage, np.array([[0.1, 0.0, -0.4]]))
    assert rows[0, 0].tolist() == pytest.approx([0.1, 0.0, -0.4])
    assert rows[0, 1].tolist() == pytest.approx([-0.05, 0.0075, -0.4])
    assert rows[0, 2].tolist() == pytest.approx([-0.05, 0.0075, -0.4])


def test_samples_lie_where_they_are_wanted(make_robot: Callable[..., DeltaRobot]) -> None:
    rng, linkage = np.random.default_rng(2), Linkage.of(make_robot().geometry)
    even_m, edge_m = spread(CYLINDER, rng, 500), edges(CYLINDER, rng, 500)
    assert len(even_m) == len(edge_m) == 500
    on_edge = np.isclose(np.hypot(edge_m[:, 0], edge_m[:, 1]), 0.2) | np.isin(
        edge_m[:, 2], CYLINDER.z_m
    )
    assert on_edge.all()
    anchor_m = hardest(CYLINDER, linkage, rng)
    # Straight below the far side of an arm's own motor: outstretched, 0.75 m long.
    assert anchor_m[2] == -0.6
    angles_rad = labels_rad(linkage, anchor_m[None])
    assert np.abs(serial_margin(linkage, angles_rad, anchor_m[None])).min() < 1e-4
    near_m = around(CYLINDER, anchor_m, rng, 400, finest_m=1e-6)
    distance_m = np.linalg.norm(near_m - anchor_m, axis=1)
    assert distance_m.min() < 1e-4 < 1e-2 < distance_m.max()
    for position_m in (even_m, edge_m, near_m):
        assert all(CYLINDER.contains(*point) for point in position_m.tolist())
