"""What `check` says of a job is what a run of it then shows."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from deltactl.firmware_py.run_report.reference import arrivals
from deltactl.recording.reading.reader import read_run

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
ROBOT = Path(__file__).parents[2] / "config" / "zhao-2023.yaml"
JOB = f"""name: rings
robot: {ROBOT}
path: {{shape: circle, centre_m: [0, 0, -0.45], radius_m: 0.05}}
timing: {{mode: accelerated, duration_s: 4}}
inverse_kinematics: {{kind: geometry}}
repeats: 3
"""


@pytest.mark.study
def test_targets_and_largest_errors(deltactl: Deltactl, tmp_path: Path) -> None:
    (tmp_path / "rings.yaml").write_text(JOB.replace("duration_s: 4", "duration_s: 2"))
    said = json.loads(deltactl("check", "rings.yaml", "--json").stdout)
    run = deltactl("run", "rings.yaml", "--simulate", "--record", "rings.mcap", "--json")
    targets = int(arrivals(read_run(tmp_path / "rings.mcap")).sum())
    assert targets == said["targets_in_all"] == 3 * said["targets"] - 2
    assert f"{targets} in 3 repeats" in deltactl("check", "rings.yaml").stdout
    tracking = json.loads(run.stdout)["tracking"]
    commanded_m = math.hypot(*(tracking["commanded"][axis]["rms_m"] for axis in "xyz"))
    assert said["limit"]["counted_m"] == pytest.approx(commanded_m, rel=0.1)
    truth = tracking["simulated truth"]
    for axis, moved_m in zip("xyz", said["microstep_m"], strict=True):
        above_m = truth[axis]["max_m"] - said["limit"]["rms_m"]
        assert 0.3 * moved_m < above_m < 1.2 * moved_m


EFFECTS = """
effects:
  - effect: gear_backlash
    component: motor2
    parameters: {width: 0.006}
    found: {recordings: [a.mcap], on: '2026-11-22', ci95: {width: [0.0058, 0.0062]}}
  - effect: home_offset
    component: motor1
    parameters: {angle: 0.006}
    found: {recordings: [a.mcap], on: '2026-11-22', ci95: {angle: [0.0058, 0.0062]}}
"""


@pytest.mark.study
def test_a_row_of_a_corrected_robot_is_what_check_promises(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    """Commands that make up for play are no error: the row was several times what was promised."""
    (tmp_path / "mine.yaml").write_text(ROBOT.read_text() + EFFECTS)
    (tmp_path / "rings.yaml").write_text(JOB.replace("repeats: 3", "repeats: 1"))
    options = ("rings.yaml", "--robot", "mine.yaml", "--json")
    limit = json.loads(deltactl("check", *options).stdout)["limit"]
    run = json.loads(deltactl("run", *options, "--simulate", "--record", "rings.mcap").stdout)
    shown = run["tracking"]["commanded"]
    commanded_m = math.hypot(*(shown[axis]["rms_m"] for axis in "xyz"))
    assert limit["counted_m"] == pytest.approx(commanded_m, rel=0.25)
    assert limit["counted_m"] < 2e-4, "corrected but for whole steps"
    even_m = math.hypot(limit["steps_m"], limit["sizes_m"], limit["left_m"])
    assert limit["rms_m"] == pytest.approx(even_m, rel=0.05)
