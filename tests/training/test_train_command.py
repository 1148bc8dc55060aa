"""`deltactl network train` as a user meets it: files, metadata, and every mistake in one line."""

from __future__ import annotations

import contextlib
import json
import resource
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deltactl.cli.main import main
from deltactl.foundation.errors import NetworkError
from deltactl.models.network import InverseNetwork, NetworkFile
from deltactl.models.robot import DeltaRobot
from deltactl.models.training.dataset import load_dataset
from deltactl.models.training.sources import of_dataset, of_geometry
from deltactl.models.training.train import settings_in_file, train_from_samples

MakeData = Callable[..., Path]
RECIPES = {"zhao": 3, "uzunovic": 5, "ours": 5}
"""Epochs or iterations: only that it runs."""


Deltactl = Callable[..., tuple[int, str, str]]


@pytest.fixture
def deltactl(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Deltactl:
    """The command line in this process (the library's import takes a second): status, out, err."""

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["deltactl", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr()
        return int(ended.value.code or 0), said.out, said.err

    return run


@pytest.mark.parametrize("recipe", RECIPES)
def test_a_trained_file_says_how_to_make_it_again(
    make_data: MakeData, zhao_robot: DeltaRobot, tmp_path: Path, recipe: Any
) -> None:
    data = load_dataset(make_data())
    out = tmp_path / "net.tflite"
    told: list[tuple[int, int, str]] = []
    source = of_dataset(data, zhao_robot)
    train_from_samples(source, recipe, out, 7, RECIPES[recipe], lambda *now: told.append(now))
    network = InverseNetwork.open(out, zhao_robot)
    training = network.metadata.training
    assert (training.recipe, training.seed, training.data) == (recipe, 7, data.digest)
    assert (training.samples, training.held_out) == (90, 30)
    assert training.machine == "simulated"
    assert training.settings == settings_in_file(recipe, RECIPES[recipe])
    assert {"python", "numpy"} <= training.versions.keys()
    assert len(training.settings) >= 5
    stated = network.metadata.validation
    assert stated.samples == 30
    assert stated.bound_deg is None
    assert stated.parity_deg is not None
    assert stated.parity_deg < 0.0225
    assert told
    assert told[-1][0] == told[-1][1]
    x_m, y_m, z_m = data.position_m.mean(axis=0)
    assert network.raw_rad_many(np.array([[x_m, y_m, z_m]])).shape == (1, 3)


def test_the_command_trains_and_answers_in_json(
    make_data: MakeData, deltactl: Deltactl, tmp_path: Path
) -> None:
    folder = make_data()
    command = ["network", "train", folder.name, "--recipe", "uzunovic", "--epochs", "5", "--json"]
    status, out, _ = deltactl(*command, "--out", "net.tflite")
    answer = json.loads(out)
    assert status == 0
    assert answer["architecture"] == "3-25-3 tanh"
    assert answer["validation"]["parity_deg"] < 0.01
    assert answer["rmse_microsteps"] == pytest.approx(answer["validation"]["rmse_deg"] / 0.0225)
    assert NetworkFile.load(tmp_path / "net.tflite").metadata.sha256 == answer["sha256"]


def test_the_nominal_robot_is_learned_without_data(deltactl: Deltactl) -> None:
    command = ["network", "train", "--robot", "zhao-2023.yaml", "--recipe", "uzunovic",
               "--samples", "200", "--epochs", "5", "--out", "n.tflite"]  # fmt: skip
    status, out, _ = deltactl(*command)
    assert status == 0
    assert "geometry, random angles; 150 samples" in out
    assert "file against float64" in out
    assert "microsteps" in out


MISTAKES: dict[str, tuple[dict[str, Any], str]] = {
    "too few": ({"count": 20}, "has 20 samples and 50 are needed"),
    "NaN": ({"spoil": "nan"}, "sample 8 has no position (NaN)"),
    "constant column": ({"spoil": "constant"}, "column z_m is the same in all samples"),
    "another robot": ({"spoil": "robot"}, "another-robot"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_in_the_data_is_one_line(
    make_data: MakeData, deltactl: Deltactl, tmp_path: Path, name: str
) -> None:
    given, expected = MISTAKES[name]
    folder = make_data(**given)
    command = ["network", "train", folder.name, "--robot", "zhao-2023.yaml", "--out", "net.tflite"]
    status, _, said = deltactl(*command)
    (line,) = said.splitlines()
    assert status == 2
    assert line.startswith("deltactl: ")
    assert expected in line
    assert not (tmp_path / "net.tflite").exists()


def test_a_data_set_whose_robot_file_is_not_there_says_which(
    make_data: MakeData, deltactl: Deltactl
) -> None:
    folder = make_data(spoil="robot")
    status, _, said = deltactl("network", "train", folder.name, "--out", "net.tflite")
    (line,) = said.splitlines()
    assert status == 2
    assert "was taken with robot 'another-robot'" in line
    assert "name that robot's file with --robot" in line


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (["--out", "net.tflite"], "nothing to learn from"),
        (["nowhere", "--out", "net.tflite"], "nowhere"),
        (["--robot", "zhao-2023.yaml", "--samples", "9", "--out", "a.tflite"], "too few"),
        (["--robot", "zhao-2023.yaml", "--out", "no/such/net.tflite"], "cannot be written"),
        (["--robot", "heart.yaml", "--out", "net.tflite"], "heart.yaml"),
    ],
)
def test_a_mistake_in_the_command_is_one_line(
    deltactl: Deltactl, command: list[str], expected: str
) -> None:
    status, _, said = deltactl("network", "train", *command)
    (line,) = said.splitlines()
    assert status == 2
    assert line.startswith("deltactl: ")
    assert expected in line


@contextlib.contextmanager
def disk_of(bytes_left: int) -> Any:
    """Files of this process may not grow beyond so many bytes: a full disk without a disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_left, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_leaves_the_old_network_as_it_was(
    zhao_robot: DeltaRobot, tmp_path: Path
) -> None:
    out = tmp_path / "net.tflite"
    source = of_geometry(zhao_robot, 100, 0)
    train_from_samples(source, "uzunovic", out, 0, 3)
    before = out.read_bytes()
    with disk_of(1000), pytest.raises(NetworkError, match="what was there is unchanged"):
        train_from_samples(source, "uzunovic", out, 1, 3)
    assert out.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["net.tflite"]
