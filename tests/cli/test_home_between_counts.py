"""Home between two counts shows in the truth of a run, and the run says so."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
JOB = """name: ring
robot: robot.yaml
path: {shape: circle, centre_m: [0, 0, -0.45], radius_m: 0.05}
timing: {mode: accelerated, duration_s: 2}
inverse_kinematics: {kind: geometry}
"""


@pytest.mark.study
@pytest.mark.parametrize(("home_deg", "between"), [(30.0, True), (31.5, False)])
def test_what_rounding_the_home_does_is_said(
    deltactl: Deltactl, tmp_path: Path, home_deg: float, between: bool
) -> None:
    """30 degrees are 1333.33 microsteps of the robot, 31.5 are 1400."""
    robot = (CONFIG_FOLDER / "zhao-2023.yaml").read_text()
    homes = f"angle_deg: [{home_deg}, {home_deg}, {home_deg}]"
    (tmp_path / "robot.yaml").write_text(robot.replace("angle_deg: [30, 30, 30]", homes))
    (tmp_path / "ring.yaml").write_text(JOB)
    shown = deltactl("run", "ring.yaml", "--simulate", "--record", "r.mcap").stdout
    said = "Home itself is rounded to whole microsteps: up to 0.06 mm of that are in z."
    assert (said in shown) is between
    report = json.loads(deltactl("report", "r.mcap", "--out", "r.html", "--json").stdout)
    (truth, commanded) = (report["tracking"][one]["z"]["rms_m"] for one in
                          ("simulated truth", "commanded"))  # fmt: skip
    assert (truth > 1.5 * commanded) is between
