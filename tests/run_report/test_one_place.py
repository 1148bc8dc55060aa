"""A job of one point: what is seen of it is seen while the platform stands there."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import deltactl as deltactl

JOB = """
name: there
robot: zhao-2023.yaml
{what}
timing: {{{timing}}}
inverse_kinematics: {{kind: geometry}}
"""
POINT = "path: {shape: points, points_m: [[0.05, 0.0, -0.45]]}"
STEPS = """steps:
  - path: {shape: points, points_m: [[0.05, 0.0, -0.45]]}
  - wait_s: 0.4
  - path: {shape: points, points_m: [[-0.05, 0.0, -0.45]]}"""
TIMINGS = ("mode: accelerated, speed_mps: 0.1", "mode: together, t_pwm_s: 0.006")


@pytest.mark.parametrize("timing", TIMINGS)
@pytest.mark.parametrize(("what", "least"), [(POINT, 12), (STEPS, 30)])
def test_one_point_has_its_errors(
    deltactl, tmp_path: Path, what: str, least: int, timing: str
) -> None:
    """The path ended as it began: one reading or none was compared with it."""
    (tmp_path / "there.yaml").write_text(JOB.format(what=what, timing=timing))
    done = json.loads(deltactl("run", "there.yaml", "--simulate", "--json").stdout)["tracking"]
    for axis in "xyz":
        assert done["simulated truth"][axis]["samples"] >= least
        assert done["simulated truth"][axis]["max_m"] < 0.0003
        assert done["measured"][axis]["samples"] >= least
