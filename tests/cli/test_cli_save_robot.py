"""A corrected robot file of a slide, from its recording: what is in it, and what is said of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pytest
import yaml

from deltactl.models.robot import ServoAxis
from deltactl.models.robot_files import load_robot_model

Deltactl = Callable[..., CompletedProcess[str]]
ROBOT = "kind: servo_axis\nname: slide\nmotion: linear\n"


def slide(path: Path) -> None:
    """Commands and readings of a slide with a shift of 1.2 mm, 0.2 % of scale, and play, which
    looks the same as friction where nothing pulls.
    """
    rng = np.random.default_rng(1)
    t_s = np.arange(0.0, 60.0, 0.05)
    command = 0.1 * np.sin(2 * np.pi * t_s / 7.3) + 0.05 * np.sin(2 * np.pi * t_s / 3.1)
    axis, read = command[0], []
    for target in command:
        axis = min(max(axis, target - 2e-5), target + 2e-5)
        read.append(1.002 * axis + 0.0012)
    position = np.array(read) + 2e-5 * rng.standard_normal(len(t_s))
    table = np.column_stack([t_s, command, position])
    np.savetxt(path, table, delimiter=",", header="t,command,position", comments="", fmt="%.9g")


@pytest.mark.study
def test_a_slides_file_says_offset_and_leaves_an_even_tie_out(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    slide(tmp_path / "slide.csv")
    (tmp_path / "slide.yaml").write_text(ROBOT, encoding="utf-8")
    words = ("diagnose", "slide.csv", "--robot", "slide.yaml", "--save-robot", "new.yaml")
    said = " ".join(deltactl(*words).stdout.split())
    assert "robot file: new.yaml, with 2 of 3 findings" in said
    assert "once more with --save-robot" not in said, "it was just given"
    assert "In the robot file: 1 and 2 (88 % sure)" in said
    assert "Left out, not certain (--save-robot NEW.yaml --all writes it too): 3 (5" in said
    assert said.endswith("check it: deltactl diagnose slide.csv --robot new.yaml")

    text = (tmp_path / "new.yaml").read_text(encoding="utf-8")
    offset, scale = yaml.safe_load(text)["effects"]
    assert offset["effect"] == "home_offset"
    assert abs(offset["parameters"].pop("offset") - 0.0012) < 1e-5
    assert not offset["parameters"]
    assert list(offset["found"]["ci95"]) == ["offset"]
    assert scale["effect"] == "gear_ratio"

    robot = load_robot_model(tmp_path / "new.yaml")
    assert isinstance(robot, ServoAxis)
    assert set(robot.effects[0].parameters) == {"angle"}
    (tmp_path / "older.yaml").write_text(text.replace("offset:", "angle:"), encoding="utf-8")
    assert load_robot_model(tmp_path / "older.yaml") == robot
