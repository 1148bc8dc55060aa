"""What a repair is worth: the interval holds what robots draw whose sizes lie in theirs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import plan_of
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.models.effects import effect_kind
from deltactl.repair.limit import reached_on, rms_m
from deltactl.repair.played import Paths, Played, played
from deltactl.repair.worth import ranked

HEART = {
    "name": "small-heart",
    "robot": "zhao-2023.yaml",
    "path": {"shape": "heart", "centre_m": [0.0, 0.0, -0.45], "width_m": 0.08},
    "timing": {"mode": "together", "t_pwm_s": 0.002},
    "inverse_kinematics": {"kind": "geometry"},
}
SIZES = {("home_offset", "motor2", "angle"): (0.01, 0.0004),
         ("gear_ratio", "motor1", "scale"): (1.004, 0.0003)}  # fmt: skip


def entry(effect: str, component: str, name: str, value: float, sigma: float) -> dict[str, Any]:
    ends = [value - 1.96 * sigma, value + 1.96 * sigma]
    found = {"recordings": ["a.mcap"], "on": "2026-11-22", "ci95": {name: ends}}
    return {"effect": effect, "component": component, "parameters": {name: value}, "found": found}


def robot_of(folder: Path, name: str, entries: list[dict[str, Any]]) -> RobotFile:
    path = folder / name
    text = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
    path.write_text(f"{text}\n{yaml.safe_dump({'effects': entries})}")
    return load_robot(path)


def planned_alone(job: Path, old: RobotFile, corrected: RobotFile, effect: str) -> Played:
    """The job by a file that has one of the corrections."""
    only = tuple(one for one in corrected.effects if one.effect == effect)
    return played(plan_of(job, old.model_copy(update={"effects": only})))


def test_the_interval_holds_what_is_drawn_and_the_best_repair_is_first(tmp_path: Path) -> None:
    job = tmp_path / "heart.yaml"
    job.write_text(yaml.safe_dump(HEART))
    entries = [entry(*name, *size) for name, size in SIZES.items()]
    old = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
    corrected = robot_of(tmp_path, "corrected.yaml", entries)
    worth = ranked(Paths(job), old, corrected)
    assert [one.effect for one in worth] == ["home_offset", "gear_ratio"]
    rng = np.random.default_rng(3)
    inside: dict[str, list[bool]] = {one.effect: [] for one in worth}
    alone = {one.effect: planned_alone(job, old, corrected, one.effect) for one in worth}
    for _ in range(12):
        true = [entry(*name, rng.normal(*size), size[1]) for name, size in SIZES.items()]
        real = robot_of(tmp_path, "true.yaml", true).effects
        for one in worth:
            path = alone[one.effect]
            drawn_m = rms_m(reached_on(old, real, path) - path.target_m)
            low_m, high_m = one.ci95_m
            assert low_m <= one.alone_m <= high_m
            inside[one.effect].append(low_m <= drawn_m <= high_m)
    assert all(sum(seen) >= 10 for seen in inside.values()), inside


def test_a_size_that_is_known_exactly_leaves_what_steps_leave(tmp_path: Path) -> None:
    """At its best a repair cannot draw better than whole steps: the interval says no less."""
    job = tmp_path / "heart.yaml"
    job.write_text(yaml.safe_dump(HEART))
    ((name, (value, _)), *_) = SIZES.items()
    old = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")
    corrected = robot_of(tmp_path, "corrected.yaml", [entry(*name, value, 1e-9)])
    (one,) = ranked(Paths(job), old, corrected)
    path = planned_alone(job, old, corrected, name[0])
    steps_m = rms_m(reached_on(old, corrected.effects, path) - path.target_m)
    low_m, high_m = one.ci95_m
    assert low_m == pytest.approx(steps_m, rel=0.05)
    assert steps_m < low_m < one.alone_m < high_m < 2.0 * steps_m


@pytest.mark.study
def test_what_an_operator_leaves_is_in_the_interval(tmp_path: Path) -> None:
    """A spring of one number is no whole arm, however exactly the number is known."""
    job = tmp_path / "heart.yaml"
    job.write_text(yaml.safe_dump(HEART))
    spring = entry("joint_compliance", "joints", "stiffness", 200.0, 1e-6)
    corrected = robot_of(tmp_path, "corrected.yaml", [spring])
    (one,) = ranked(Paths(job), load_robot(CONFIG_FOLDER / "zhao-2023.yaml"), corrected)
    left_m = np.sqrt(effect_kind("joint_compliance").discrepancy.elsewhere) * one.now_m
    low_m, high_m = one.ci95_m
    assert low_m < 0.3 * left_m
    assert left_m < high_m < 1.2 * left_m


def test_what_moves_no_count_is_no_repair(tmp_path: Path) -> None:
    job = tmp_path / "heart.yaml"
    job.write_text(yaml.safe_dump(HEART))
    stop = entry("contact", "platform", "height", -0.6, 1e-4)
    name, (value, sigma) = next(iter(SIZES.items()))
    corrected = robot_of(tmp_path, "corrected.yaml", [stop, entry(*name, value, sigma)])
    (only,) = ranked(Paths(job), load_robot(CONFIG_FOLDER / "zhao-2023.yaml"), corrected)
    assert only.effect == name[0]
