"""`deltactl network evaluate`: a network beside geometry and a calibration."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

pytest.importorskip("mujoco", reason="the as-built robot needs the extra 'proof'")
pytest.importorskip("tflite", reason="training needs the extra 'training'")

from deltactl.firmware_py.evaluating.held_out import held_out
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.network.file import NetworkFile
from deltactl.models.training.dataset import load_dataset
from deltactl.models.training.sources import of_dataset
from deltactl.models.training.train import train_from_samples

ROBOT = load_robot(find("zhao-2023.yaml"))


@pytest.fixture(scope="module")
def network(surveyed: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("network") / "small.tflite"
    source = of_dataset(load_dataset(surveyed), ROBOT, first=100)
    train_from_samples(source, "uzunovic", path, effort=10)
    return path


@pytest.mark.study
def test_only_what_it_did_not_see_judges_it(surveyed: Path, network: Path) -> None:
    data = load_dataset(surveyed)
    held = held_out(data, NetworkFile.load(network).metadata)
    assert len(held.judged) == 45  # a quarter of 100, and the 20 after them
    assert len(held.trained) == 75
    assert not set(held.judged) & set(held.trained)


@pytest.mark.study
def test_held_out_errors_and_curves(here, surveyed: Path, network: Path, tmp_path: Path) -> None:
    saved = tmp_path / "calibrated.yaml"
    words = (
        "network",
        "evaluate",
        network,
        "--data",
        surveyed,
        "--as-built",
        "zhao-2023",
        "--part",
        "0.02",
    )
    done = here(*words, "--save-robot", saved, "--json")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    median = {name: max(one["joint_median_deg"]) for name, one in answer["held_out"].items()}
    assert median["calibrated"] < 0.5 < 5.0 < median["geometry"]
    assert len(answer["curves"]) == 3 * 3 * 4
    z_m = {
        row["model"]: row["rms_true_m"][2]
        for row in answer["curves"]
        if row["curve"] == "circle" and row["t_pwm_s"] == 0.006
    }
    assert z_m["calibrated"] < 0.005 < 0.05 < z_m["geometry"]
    assert load_robot(saved).effects
    # The network is of the machine, whose file this is now: 13 degrees from the design's angles.
    NetworkFile.load(network).check(load_robot(saved))
    shown = here("network", "evaluate", network, "--data", surveyed)
    assert shown.returncode == 0, shown.stderr
    assert "45 samples it was not trained on" in shown.stdout


def test_bad_input_is_one_line(here, surveyed: Path, network: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.tflite"
    broken.write_bytes(network.read_bytes()[:-40] + bytes(40))
    other = ("--robot", "zhao-2023-as-printed.yaml")
    for words, said in (
        (("network", "evaluate", broken, "--data", surveyed), "broken.tflite"),
        (("network", "evaluate", tmp_path / "none.tflite", "--data", surveyed), "none.tflite"),
        (("network", "evaluate", network, "--data", tmp_path), "settings.yaml"),
        (("network", "evaluate", network, "--data", surveyed, *other), "was taken with robot"),
        (
            ("network", "evaluate", network, "--data", surveyed, "--save-robot", broken),
            "exists already",
        ),
        (
            ("network", "evaluate", network, "--data", surveyed, "--as-built", "none.yaml"),
            "none.yaml",
        ),
    ):
        done = here(*words)
        assert done.returncode == 2
        assert done.stdout == ""
        assert len(done.stderr.strip().splitlines()) == 1
        assert said in done.stderr
