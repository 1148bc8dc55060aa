"""A table of another kind of machine than the robot file describes is named for what it is."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
CONFIG = Path(__file__).parents[2] / "config"
COLUMNS = {
    "delta": ("steps_1", "steps_2", "steps_3", "range_x", "range_y", "range_z"),
    "stepper_axis": ("steps_1", "theta_1"),
    "servo_axis": ("command", "position"),
    "range_sensor": ("distance", "range"),
}
DESCRIBED = {
    "delta": "delta run-robot.yaml",
    "stepper_axis": "axis run-robot.yaml --drive stepper",
    "servo_axis": "axis run-robot.yaml",
    "range_sensor": "sensor run-robot.yaml",
}


@pytest.mark.parametrize(
    ("kind", "robot"),
    [
        ("delta", "servo-axis"),
        ("delta", "stepper-axis"),
        ("delta", "range-sensor"),
        ("stepper_axis", "zhao-2023"),
        ("stepper_axis", "gripper-delta"),
        ("servo_axis", "zhao-2023"),
        ("servo_axis", "range-sensor"),
        ("range_sensor", "zhao-2023"),
        ("range_sensor", "servo-axis"),
    ],
)
def test_another_kind_of_machine(deltactl: Deltactl, tmp_path: Path, kind: str, robot: str) -> None:
    _table(tmp_path / "run.csv", kind)
    said = deltactl(
        "diagnose", "run.csv", "--robot", str(CONFIG / f"{robot}.yaml"), status=2
    ).stderr
    assert f"looks like a table of a {kind}" in said
    assert "deltactl inspect run.csv" in said
    assert f"deltactl init {DESCRIBED[kind]}" in said
    assert len(said.splitlines()) == 1


def test_a_column_missing_of_the_same_kind_is_only_that(deltactl: Deltactl, tmp_path: Path) -> None:
    _table(tmp_path / "run.csv", "range_sensor", without="distance")
    robot = str(CONFIG / "range-sensor.yaml")
    said = deltactl("diagnose", "run.csv", "--robot", robot, status=2).stderr
    assert "column distance missing" in said
    assert "looks like" not in said


def _table(path: Path, kind: str, without: str = "") -> None:
    """Half a minute of columns that go to and fro; counts are whole numbers."""
    names = [name for name in COLUMNS[kind] if name != without]
    t_s = 0.02 * np.arange(1500)
    swing = np.sin(0.7 * t_s)
    values = [np.round(200 * swing) if name.startswith("steps") else 1 + swing for name in names]
    np.savetxt(
        path, np.stack([t_s, *values], axis=1), "%.6g", ",", header=",".join(["t", *names]),
        comments="",
    )  # fmt: skip
