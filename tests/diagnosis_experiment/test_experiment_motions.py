"""Every motion of the table is one that `deltactl run` accepts; limits of the robot file hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from deltactl.diagnosis.answer.records import NextExperiment
from deltactl.diagnosis.experiment import write_job
from deltactl.diagnosis.plants.delta.motions import motions
from deltactl.diagnosis.plants.delta.next_runs import duration_s, job_of
from deltactl.diagnosis.plants.delta.safe_poses import MotionLimits, is_safe
from deltactl.firmware_py.named_files import CONFIG_FOLDER, find
from deltactl.firmware_py.program.totals import check_job
from deltactl.firmware_py.robot_file import load_robot
from deltactl.models.linkage import Linkage, forward

ROBOTS = ("zhao-2023.yaml", "uzunovic-2013.yaml")


def table(name: str, motors: set[int]) -> Any:
    robot = load_robot(find(name))
    limits = MotionLimits.of(yaml.safe_load(find(name).read_text(encoding="utf-8")))
    step = robot.drive.rad_per_step
    return robot, list(motions(Linkage.of(robot.geometry), limits, step, 0.2, motors))


@pytest.mark.parametrize("name", ROBOTS)
def test_the_planner_accepts_every_motion_and_takes_as_long(name: str, tmp_path: Path) -> None:
    robot, found = table(name, {1})
    assert {m.name.removesuffix("-slow") for m in found} == {
        "survey", "survey-rests", "circle", "circles-both-ways", "both-sides", "sweep",
        "up-and-down", "far-poses",
    }  # fmt: skip
    for motion in found:
        path = tmp_path / f"{motion.name}.yaml"
        job = job_of(motion, robot.name, 1)
        path.write_text(yaml.safe_dump(job), encoding="utf-8")
        summary = check_job(path)
        own_s = duration_s(motion, robot.drive.rad_per_step)
        assert summary.duration_s - summary.approach_s == pytest.approx(own_s, rel=0.01, abs=0.1)


def test_circles_go_both_ways_round() -> None:
    robot, found = table("zhao-2023.yaml", {0})
    motion = next(m for m in found if m.name == "circles-both-ways")
    at = forward(Linkage.of(robot.geometry), motion.angles_rad).position_m
    turned = at[:-1, 0] * at[1:, 1] - at[:-1, 1] * at[1:, 0]
    assert (turned > 1e-4).sum() == pytest.approx((turned < -1e-4).sum(), abs=2)
    assert np.ptp(at[:, 2]) > 0.05


def test_a_narrow_robot_file_narrows_the_motions() -> None:
    robot = load_robot(find("zhao-2023.yaml"))
    linkage = Linkage.of(robot.geometry)
    box = [[-0.05, 0.05], [-0.05, 0.05], [-0.6, -0.3]]
    limits = MotionLimits.of(
        {"limits": {"arm_deg": [10, 60], "box_m": box}, "steps": {"backend": "gpiozero"}}
    )
    found = list(motions(linkage, limits, robot.drive.rad_per_step, 0.2, {0}))
    assert found
    for motion in found:
        assert motion.t_pwm_s >= 2e-3
        assert motion.angles_deg.min() >= 10.0
        assert motion.angles_deg.max() <= 60.0
        at = forward(linkage, motion.angles_rad).position_m
        assert np.abs(at[:, :2]).max() <= 0.05


def test_a_pose_near_singular_on_the_way_is_not_safe() -> None:
    linkage = Linkage.of(load_robot(find("zhao-2023.yaml")).geometry)
    down, flat = np.deg2rad([[40.0] * 3, [0.0] * 3])
    assert is_safe(linkage, MotionLimits(), np.array([down, down + 0.2]))
    assert not is_safe(linkage, MotionLimits(), np.array([down, flat]))


@pytest.mark.parametrize(
    "given", [{}, {"limits": "none"}, {"limits": {"arm_deg": [1]}}, {"limits": None}]
)
def test_limits_that_are_missing_or_wrong_are_the_default(given: dict[str, Any]) -> None:
    assert MotionLimits.of(given) == MotionLimits()


def test_the_written_job_is_checked_as_it_stands(tmp_path: Path) -> None:
    robot, found = table("zhao-2023.yaml", {2})
    plan = NextExperiment(
        job=job_of(found[0], robot.name, 3), tells_apart=["a b", "c d"],
        expected_delta_chi2=50.0, minutes=2.0,
    )  # fmt: skip
    write_job(plan, tmp_path / "next.yaml", find("zhao-2023.yaml"), CONFIG_FOLDER)
    assert "robot: zhao-2023.yaml" in (tmp_path / "next.yaml").read_text(encoding="utf-8")
    assert check_job(tmp_path / "next.yaml").duration_s > 3.0 * duration_s(
        found[0], robot.drive.rad_per_step
    )
