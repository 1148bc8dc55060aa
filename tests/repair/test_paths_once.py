"""A job is planned once for equal robot files, and again for others."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import plan_of
from deltactl.firmware_py.robot_file import load_robot
from deltactl.repair.campaign import JOB
from deltactl.repair.played import Paths, played

TEXT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()


def robot_file(folder: Path, angle_rad: float) -> Path:
    home = {"effect": "home_offset", "component": "motor2", "parameters": {"angle": angle_rad}}
    path = folder / f"{angle_rad}.yaml"
    path.write_text(f"{TEXT}\n{yaml.safe_dump({'effects': [home]})}")
    return path


@pytest.mark.study
def test_equal_robots_are_planned_once_and_others_as_without_memory(tmp_path: Path) -> None:
    first, other = robot_file(tmp_path, 0.01), robot_file(tmp_path, 0.02)
    paths = Paths(JOB)
    once = paths.of(load_robot(first))
    assert paths.of(load_robot(first)) is once
    moved = paths.path(load_robot(other))
    assert not moved.is_same_as(once[1])
    assert moved.is_same_as(played(plan_of(JOB, load_robot(other))))


@pytest.mark.study
def test_only_the_last_that_were_asked_for_are_kept(tmp_path: Path) -> None:
    first, second, third = (load_robot(robot_file(tmp_path, size)) for size in (0.01, 0.02, 0.03))
    paths = Paths(JOB, 2)
    kept, gone = paths.path(first), paths.path(second)
    assert paths.path(first) is kept
    paths.path(third)
    assert paths.path(first) is kept
    assert paths.path(second) is not gone
