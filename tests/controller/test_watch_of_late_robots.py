"""Delays that the robot file has are no lost steps; steps that are lost beside them are seen."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest
import yaml

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.clock import sleep_s

TEXT = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
HEART = {
    "name": "small-heart",
    "robot": "mine.yaml",
    "path": {"shape": "heart", "centre_m": [0.0, 0.0, -0.45], "width_m": 0.08},
    "timing": {"mode": "together", "t_pwm_s": 0.002},
    "inverse_kinematics": {"kind": "geometry"},
}
LATE = {
    "lag": ("following_lag", "motor2", {"time": 0.195, "dead_time": 0.0}),
    "dead time": ("following_lag", "motor1", {"time": 0.0, "dead_time": 0.195}),
    "both": ("following_lag", "motor3", {"time": 0.06, "dead_time": 0.12}),
    "readings": ("sensor_latency", "sensors", {"time": 0.15}),
}
LOST = 200


def run(folder: Path, late: str, lost: int = 0) -> JobResult:
    name, component, sizes = LATE[late]
    effects = [{"effect": name, "component": component, "parameters": sizes}]
    (folder / "mine.yaml").write_text(f"{TEXT}\n{yaml.safe_dump({'effects': effects})}")
    job = folder / "heart.yaml"
    job.write_text(yaml.safe_dump(HEART))
    robot = build_controller(
        folder / "mine.yaml", simulated=True, realtime=False, recordings=folder
    )
    with closing(robot):
        robot.power_on()
        robot.home()
        number = robot.submit(job)
        while (result := robot.result(number)) is None:
            sleep_s(robot.clock, 0.5)
            if lost and robot.status().progress > 0.4:
                assert robot.machine.bench is not None
                robot.machine.bench.slip(1, lost)
                lost = 0
    return result


@pytest.mark.study
@pytest.mark.parametrize("late", sorted(LATE))
def test_a_delay_in_the_robot_file_is_no_loss(tmp_path: Path, late: str) -> None:
    result = run(tmp_path, late)
    assert (result.outcome, result.why, result.warning) == ("done", "", "")


@pytest.mark.parametrize("late", ["both", "readings"])
def test_lost_steps_beside_it_are_seen(tmp_path: Path, late: str) -> None:
    result = run(tmp_path, late, LOST)
    assert result.outcome == "fault"
    assert "motor1" in result.why
