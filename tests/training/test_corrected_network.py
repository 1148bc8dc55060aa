"""A network trained for a robot file with effects answers as the exact inverse of what is known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.network import InverseNetwork
from deltactl.models.network.metadata import Cylinder
from deltactl.models.robot import EffectEntry
from deltactl.models.robot_files import load_delta
from deltactl.models.training.corrected import EFFORT, train_corrected
from deltactl.models.training.recipe import Task


@pytest.mark.study
def test_it_learns_what_the_file_knows_and_says_so(tmp_path: Path) -> None:
    home = EffectEntry(effect="home_offset", component="motor1", parameters={"angle": 0.02})
    late = EffectEntry(effect="following_lag", component="motor1", parameters={"time": 0.02})
    robot = load_delta(CONFIG_FOLDER / "zhao-2023.yaml").model_copy(
        update={"effects": (home, late)}
    )
    effort = replace(EFFORT, hidden=(8, 8), spread=600, edge=200, iterations=60, rounds=0)
    task = Task(robot, Cylinder(radius_m=0.1, z_m=(-0.5, -0.45)), 0)
    written = train_corrected(task, tmp_path / "net.tflite", effort)
    network = InverseNetwork.open(written.file.path, robot)
    assert network.metadata.robot.effects == (home,)
    targets_m = np.array([[0.05, 0.02, -0.47], [-0.03, 0.06, -0.49]])
    wanted = CalibratedInverse(robot).angles_rad_many(targets_m)
    answers = network.angles_rad_many(targets_m)
    step_rad = 2.0 * np.pi / 16_000
    assert np.abs(answers - wanted).max() < step_rad  # and a correction is fifty of them
