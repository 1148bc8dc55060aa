"""Whole runs on the simulated robot: what feedback does when steps are lost, and when not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.run_report.reference import path_windows, targets_at
from deltactl.foundation.clock import sleep_s
from deltactl.models.robot import FloatArray
from deltactl.recording.reading.reader import read_run

JOB = {
    "name": "circle",
    "robot": "robot.yaml",
    "path": {"shape": "circle", "centre_m": [0.0, 0.0, -0.45], "radius_m": 0.06},
    "timing": {"mode": "together", "t_pwm_s": 0.006},
    "inverse_kinematics": {"kind": "geometry"},
    "on_step_loss": "warn",
}


def run(folder: Path, effects: list[Any], **job: Any) -> tuple[JobResult, FloatArray, FloatArray]:
    """How the job ended, and its true error [m] at times [s] along the path."""
    folder.mkdir()
    robot = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
    robot += f"\n{yaml.safe_dump({'as_built': {'effects': effects}})}"
    (folder / "robot.yaml").write_text(robot)
    (folder / "job.yaml").write_text(yaml.safe_dump(JOB | job))
    controller = build_controller(
        folder / "robot.yaml", simulated=True, realtime=False, recordings=folder
    )
    try:
        controller.power_on()
        controller.home()
        number = controller.submit(folder / "job.yaml")
        while (result := controller.result(number)) is None:
            sleep_s(controller.clock, 0.5)
    finally:
        controller.close()
    assert result.recording is not None
    recorded = read_run(Path(result.recording))
    t_s = recorded.truth.t_ns * 1e-9
    error_m = np.linalg.norm(recorded.truth.position_m - targets_at(recorded, t_s), axis=1)
    ((start_ns, end_ns),) = path_windows(recorded)
    inside = (t_s > start_ns * 1e-9) & (t_s < end_ns * 1e-9) & np.isfinite(error_m)
    return result, t_s[inside], error_m[inside]


@pytest.mark.study
def test_lost_steps_are_made_up_for_within_five_seconds_without_a_stop(tmp_path: Path) -> None:
    lost = {"effect": "lost_steps", "component": "motor2",
            "parameters": {"steps": 100.0, "time": 12.0}}  # fmt: skip
    result, t_s, error_m = run(tmp_path / "lost", [lost], feedback={})
    assert result.outcome == "done"
    assert "feedback added" in result.warning
    far = t_s[error_m > 2e-3]
    assert error_m[t_s > far[0] + 5.0].max() < 0.5e-3


@pytest.mark.study
def test_late_readings_are_told_as_no_lost_steps(tmp_path: Path) -> None:
    late = {"effect": "sensor_latency", "component": "sensors", "parameters": {"time": 0.2}}
    half = {"path": JOB["path"] | {"radius_m": 0.03}}
    result, _, error_m = run(tmp_path / "late", [late], feedback={}, **half)
    assert (result.outcome, result.warning) == ("done", "")
    assert error_m.max() < 1e-3
    _, _, opened = run(tmp_path / "open", [], **half)
    rms = [float(np.sqrt(np.mean(error**2))) for error in (opened, error_m)]
    assert rms[1] <= 1.05 * rms[0]


@pytest.mark.study
def test_an_emergency_stop_while_feedback_corrects_ends_both(tmp_path: Path) -> None:
    robot = tmp_path / "robot.yaml"
    robot.write_text((CONFIG_FOLDER / "zhao-2023.yaml").read_text())
    (tmp_path / "job.yaml").write_text(yaml.safe_dump(JOB | {"feedback": {}}))
    controller = build_controller(robot, simulated=True, realtime=False, recordings=tmp_path)
    bench = controller.machine.bench
    assert bench is not None
    try:
        controller.power_on()
        controller.home()
        number = controller.submit(tmp_path / "job.yaml")
        sleep_s(controller.clock, 6.0)
        bench.slip(2, 100)
        sleep_s(controller.clock, 2.5)
        job = controller.jobs.running
        assert job is not None
        assert job.feedback is not None
        assert job.feedback.offset[1] > 0
        bench.press_estop()
        sleep_s(controller.clock, 0.2)
        stopped = bench.counts()
        sleep_s(controller.clock, 1.0)
        assert bench.counts() == stopped
        assert controller.status().state == "stopped"
        result = controller.result(number)
        assert result is not None
        assert result.outcome == "stopped"
        bench.release_estop()
        controller.acknowledge()
        controller.power_off()  # the arms are put back against their stops
        controller.power_on()
        controller.home()
        assert controller.status().state == "ready"
    finally:
        controller.close()
