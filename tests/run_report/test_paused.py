"""What is asked for stands still while a run is paused, and slows down as the robot does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.run_report.tracking import robot_of, track
from deltactl.foundation.clock import sleep_s
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run

JOB = """
name: far
robot: zhao-2023.yaml
path: {shape: way, start_m: [0.05, 0.0, -0.45], legs: [{to_m: [-0.05, 0.0, -0.45]}],
  spacing_m: 0.004}
timing: {TIMING}
inverse_kinematics: {kind: geometry}
"""
TIMINGS = ("mode: accelerated, speed_mps: 0.02", "mode: together, t_pwm_s: 0.01")


def largest_m(tmp_path: Path, timing: str, *pressed: tuple[float, str]) -> tuple[float, Run]:
    """Largest error of the platform on the path, after buttons were pressed at times [s]."""
    tmp_path.mkdir()
    job = tmp_path / "far.yaml"
    job.write_text(JOB.replace("TIMING", timing))
    controller = build_controller(
        CONFIG_FOLDER / "zhao-2023.yaml",
        simulated=True,
        realtime=False,
        recordings=tmp_path / "recordings",
    )
    controller.power_on()
    controller.home()
    number = controller.submit(job)
    while controller.jobs.running is None or controller.jobs.running.phase.value != "path":
        sleep_s(controller.clock, 0.02)
    for wait_s, button in pressed:
        sleep_s(controller.clock, wait_s)
        getattr(controller, button)()
    while (result := controller.result(number)) is None:
        sleep_s(controller.clock, 0.1)
    controller.close()
    run = read_run(Path(result.recording))
    truth = track(run, robot_of(run)).truth
    assert truth is not None
    assert min(truth.samples) > 50
    return max(truth.max_m), run


@pytest.mark.study
@pytest.mark.parametrize("timing", TIMINGS)
def test_a_pause_is_no_error(tmp_path: Path, timing: str) -> None:
    """Targets are 4 mm apart, and the reference went on to the next one during the pause."""
    never_m, _ = largest_m(tmp_path / "never", timing)
    pressed = (0.83, "pause"), (2.0, "resume"), (0.31, "pause"), (0.15, "resume")
    paused_m, run = largest_m(tmp_path / "paused", timing, *pressed)
    assert run.paces.goal.tolist() == [0.0, 1.0, 0.0, 1.0]
    assert np.all(run.paces.ramp_s > 0.0)
    assert paused_m < 1.3 * never_m


@pytest.mark.study
def test_a_run_that_is_cancelled_errs_no_more_up_to_there(tmp_path: Path) -> None:
    never_m, _ = largest_m(tmp_path / "never", TIMINGS[0])
    ended_m, run = largest_m(tmp_path / "ended", TIMINGS[0], (1.13, "cancel"))
    assert run.paces.goal.tolist() == [0.0]
    assert ended_m < 1.3 * never_m
