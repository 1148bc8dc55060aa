"""`deltactl demo prove --heal`: a robot of the independent simulator draws better afterwards."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.firmware_py.robot_file import load_robot
from deltactl.repair.campaign import JOB, ROBOT
from deltactl.repair.heal import Healer, Order
from deltactl.repair.heal_answer import IMPROVED
from deltactl.repair.heal_campaign import ProofPatient
from deltactl.repair.machine import faulty_robot
from deltactl.repair.played import Paths
from deltactl.repair.surveys import MOST_ROBOT_S


@pytest.mark.study
def test_a_robot_that_shares_nothing_with_the_model_heals(tmp_path: Path) -> None:
    words = ("demo", "prove", "--heal", "--cases", "1", "--seed", "5", "--workers", "0", "--out")
    done = CliRunner().invoke(app, [*words, str(tmp_path)])
    assert done.exit_code == 0, done.output
    row = json.loads((tmp_path / "heal-5-0000.json").read_text())
    assert row["hidden"] == ["upper_arm_length"]
    assert row["outcome"] == "healed"
    assert row["after_m"] < 0.15e-3 < row["before_m"]
    assert "1 of 1" in done.output


@pytest.mark.study
def test_a_drawn_robot_that_misses_its_goal_is_not_called_healed(tmp_path: Path) -> None:
    """A quarter of what its steps leave is asked for, which no correction reaches."""
    robot_file = tmp_path / ROBOT.name
    robot_file.write_bytes(ROBOT.read_bytes())
    machine, paths = faulty_robot(["upper_arm_length"], 5506000), Paths(JOB)
    order = Order(robot_file, JOB, tmp_path / "healing", minutes=2.0, goal_m=1e-5)
    answer = Healer(order, ProofPatient(machine, JOB, paths), lambda _: None, paths).heal()
    after_m = machine.draw(paths.path(load_robot(robot_file))).rms_m
    assert order.goal_m is not None
    assert after_m > order.goal_m
    assert answer["outcome"] == IMPROVED
    low_m, high_m = answer["expected_ci95_m"]
    assert low_m < after_m < 1.2 * high_m


@pytest.mark.study
def test_drawings_end_with_the_time_of_the_robot(tmp_path: Path) -> None:
    """Arms that grow by a little, which few drawings show: none is begun that would be too long."""
    robot_file = tmp_path / ROBOT.name
    robot_file.write_bytes(ROBOT.read_bytes())
    machine, paths = faulty_robot(["contact", "thermal_expansion"], 5521105), Paths(JOB)
    order = Order(robot_file, JOB, tmp_path / "healing", goal_m=1e-6)
    answer = Healer(order, ProofPatient(machine, JOB, paths), lambda _: None, paths).heal()
    assert answer["robot_s"] < MOST_ROBOT_S
