"""A path with a led drive: its steps are ones that the output takes, or the path is slower."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.planner.plan import Plan, plan_of
from deltactl.firmware_py.planner.summary import slower
from deltactl.firmware_py.program.coverage import coverage_of
from deltactl.firmware_py.robot_file import load_robot
from deltactl.repair.limit import Limit, limit_of, reached_on, rms_m
from deltactl.repair.played import played

TEXT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
HEART = {
    "name": "small-heart",
    "robot": "mine.yaml",
    "path": {"shape": "heart", "centre_m": [0.0, 0.0, -0.45], "width_m": 0.08},
    "inverse_kinematics": {"kind": "geometry"},
}
TIMINGS = {
    "together": {"mode": "together", "t_pwm_s": 0.002},
    "accelerated": {"mode": "accelerated", "speed_mps": 0.2},
}


def written(folder: Path, lag_s: float, dead_s: float, timing: str, rate_hz: int = 20000) -> Path:
    """A robot with a late drive that it has accepted, and a job; the job."""
    late = {"time": lag_s, "dead_time": dead_s}
    effects = [{"effect": "following_lag", "component": "motor2", "parameters": late}]
    text = TEXT.replace("step_rate_hz: 20000", f"step_rate_hz: {rate_hz}")
    (folder / "mine.yaml").write_text(f"{text}\n{yaml.safe_dump({'effects': effects})}")
    job = folder / "heart.yaml"
    job.write_text(yaml.safe_dump(HEART | {"timing": TIMINGS[timing]}))
    return job


def limit(job: Path) -> Limit:
    found = limit_of(plan_of(job), coverage_of(job, job.with_name("mine.yaml")))
    assert found is not None
    return found


@pytest.mark.parametrize("timing", sorted(TIMINGS))
@pytest.mark.parametrize(("lag_s", "dead_s"), [(0.195, 0.0), (0.05, 0.15), (0.0, 0.195)])
def test_ticks_are_as_far_apart_as_the_output_takes(
    tmp_path: Path, timing: str, lag_s: float, dead_s: float
) -> None:
    plan = plan_of(written(tmp_path, lag_s, dead_s, timing))
    path = played(plan)
    assert np.diff(path.due_s[1:]).min() >= plan.robot.tick_s
    for motor in range(3):
        moves = np.flatnonzero(np.diff(path.counts[:, motor])) + 1
        assert np.diff(path.due_s[moves]).min() >= 1.0 / plan.robot.limits.step_rate_hz - 1e-9
    assert plan.first.led == 1.0


@pytest.mark.parametrize("timing", sorted(TIMINGS))
def test_a_path_is_slowed_until_its_drive_can_be_led_and_that_is_said(
    tmp_path: Path, timing: str
) -> None:
    free = limit(written(tmp_path, 0.195, 0.0, timing))
    job = written(tmp_path, 0.195, 0.0, timing, rate_hz=600)
    plan = plan_of(job)
    assert plan.first.led > 1.2
    assert limit(job).steps_m < 1.3 * free.steps_m
    says = slower([plan])
    assert says is not None
    assert "step_rate_hz 600" in says.says()
    assert played(plan).seconds > 1.2 * played(plan_of(written(tmp_path, 0.0, 0.0, timing))).seconds
    assert limit_of(plan_of(job), coverage_of(job, tmp_path / "mine.yaml")) is not None


def test_a_drive_that_follows_at_once_slows_no_path(tmp_path: Path) -> None:
    plan = plan_of(written(tmp_path, 0.0, 0.0, "together", rate_hz=600))
    assert plan.first.led == 1.0
    assert load_robot(tmp_path / "mine.yaml").effects


def test_a_led_drive_comes_gently_to_a_path_that_begins_with_another_move(tmp_path: Path) -> None:
    """Where play of motor 1 is taken up first, motor 3 stops, and is to set out at once."""
    job = written(tmp_path, 0.15, 0.0, "together")
    play = {"effect": "joint_friction", "component": "motor1", "parameters": {"width": 0.0078}}
    mine = job.with_name("mine.yaml")
    text = mine.read_text().replace("component: motor2", "component: motor3")
    mine.write_text(text + yaml.safe_dump([play]))
    job.write_text(job.read_text().replace("width_m: 0.08", "width_m: 0.2"))
    plan = plan_of(job)
    assert plan.first_dwell_s == 0.0
    assert left_m(plan) < 6e-5


def left_m(plan: Plan) -> float:
    path = played(plan)
    return rms_m(reached_on(plan.robot, plan.robot.effects, path) - path.target_m)
