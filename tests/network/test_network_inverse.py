"""Running a network: which targets it answers, and that one and many agree."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from deltactl.foundation.errors import LimitExceeded, MissingFile, NetworkError
from deltactl.models.network import InverseNetwork, NetworkFile, inverse
from deltactl.models.robot import DeltaRobot
from deltactl.models.training.recipe import Task


@pytest.fixture
def network(write: Callable[..., NetworkFile], make_network: Callable[..., Any]) -> InverseNetwork:
    return InverseNetwork(write(make_network()))


def test_one_target_and_many_give_the_same_numbers(network: InverseNetwork) -> None:
    position_m = np.random.default_rng(0).uniform((-0.1, -0.1, -0.5), (0.1, 0.1, -0.4), (300, 3))
    many = network.angles_rad_many(position_m)
    one_by_one = [network.angles_rad(*target) for target in position_m.tolist()]
    assert many.dtype == np.float64
    assert many.tolist() == [list(angles) for angles in one_by_one]
    assert many.tolist() == network.raw_rad_many(position_m).tolist()


def test_no_targets_give_no_angles(network: InverseNetwork) -> None:
    assert network.angles_rad_many(np.empty((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(
    "target_m",
    [(0.11, 0.0, -0.45), (0.0, -0.11, -0.45), (0.0, 0.0, -0.39), (0.0, 0.0, float("nan"))],
)
def test_a_target_outside_the_trained_region_is_refused(
    network: InverseNetwork, target_m: tuple[float, float, float]
) -> None:
    with pytest.raises(LimitExceeded, match=r"outside what bench\.tflite was trained for") as one:
        network.angles_rad(*target_m)
    with pytest.raises(LimitExceeded) as many:
        network.angles_rad_many(np.array([(0.0, 0.0, -0.45), target_m]))
    assert str(one.value) == str(many.value)
    assert "\n" not in str(one.value)


def test_an_answer_outside_the_trained_angles_is_refused(
    write: Callable[..., NetworkFile], make_network: Callable[..., Any]
) -> None:
    file = write(make_network())
    angle_deg = np.rad2deg(InverseNetwork(file).angles_rad(0.0, 0.0, -0.45))
    just_below = file.metadata.model_copy(update={"angle_deg": (-180.0, angle_deg.max() - 0.01)})
    narrowed = InverseNetwork(NetworkFile(file.path, file.content, just_below))
    with pytest.raises(LimitExceeded, match="needs arm angles"):
        narrowed.angles_rad(0.0, 0.0, -0.45)
    just_above = file.metadata.model_copy(update={"angle_deg": (-180.0, angle_deg.max() + 0.01)})
    InverseNetwork(NetworkFile(file.path, file.content, just_above)).angles_rad(0.0, 0.0, -0.45)


def test_a_file_is_opened_for_its_own_robot_only(
    network: InverseNetwork, task: Task, make_robot: Callable[..., DeltaRobot]
) -> None:
    path = network.file.path
    opened = InverseNetwork.open(path, task.robot)
    assert opened.angles_rad(0.0, 0.0, -0.45) == network.angles_rad(0.0, 0.0, -0.45)
    with pytest.raises(NetworkError, match="not for 'other'"):
        InverseNetwork.open(path, make_robot("other"))
    with pytest.raises(MissingFile):
        InverseNetwork.open(path.with_name("absent.tflite"), task.robot)


def test_a_network_of_another_shape_is_refused(
    network: InverseNetwork, make_network: Callable[..., Any]
) -> None:
    for sizes, role in (((2, 4, 3), "input"), ((3, 4, 2), "output")):
        trained = make_network(sizes).trained
        content = trained.graph.to_bytes(trained.source, trained.result, "", b"{}")
        with pytest.raises(NetworkError, match=f"its {role} has shape"):
            InverseNetwork(NetworkFile(network.file.path, content, network.metadata))


@pytest.mark.study
def test_bytes_that_the_runtime_refuses_are_one_line(network: InverseNetwork) -> None:
    content = network.file.content.replace(b"TFL3", b"TFL9")
    with pytest.raises(NetworkError, match="runtime refuses") as caught:
        InverseNetwork(NetworkFile(network.file.path, content, network.metadata))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("python", "numpy_version", "names"),
    [
        ((3, 11), "1.26.4", ("tflite_runtime", "ai_edge_litert")),
        ((3, 11), "2.1.0", ("ai_edge_litert",)),
        ((3, 13), "2.5.0", ("ai_edge_litert",)),
        ((3, 13), "1.26.4", ("ai_edge_litert", "tflite_runtime")),
    ],
)
def test_the_runtime_fits_python_and_numpy(
    monkeypatch: pytest.MonkeyPatch,
    python: tuple[int, int],
    numpy_version: str,
    names: tuple[str, ...],
) -> None:
    monkeypatch.setattr(sys, "version_info", (*python, 0))
    monkeypatch.setattr(inverse.np, "__version__", numpy_version)
    assert inverse.runtime_names() == names


def test_a_missing_runtime_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in inverse.RUNTIMES:
        monkeypatch.setitem(sys.modules, f"{name}.interpreter", None)
    with pytest.raises(NetworkError, match=r"install (tflite-runtime|ai-edge-litert)"):
        inverse.open_interpreter(b"")
