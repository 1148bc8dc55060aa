"""A speed that a path never reaches is said, with what is reached and why; nothing is refused."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
CONFIG = Path(__file__).parents[2] / "config"
JOB = """
name: fast
robot: {robot}
path: {{shape: circle, centre_m: [0, 0, -0.45], radius_m: 0.02}}
timing: {{mode: accelerated, speed_mps: {speed}{more}}}
inverse_kinematics: {{kind: geometry}}
"""


def _job(folder: Path, speed: float, more: str = "") -> None:
    text = JOB.format(robot=CONFIG / "zhao-2023.yaml", speed=speed, more=more)
    (folder / "fast.yaml").write_text(text)


def test_it_is_said_before_and_after_the_run(deltactl: Deltactl, tmp_path: Path) -> None:
    _job(tmp_path, 6.28, ", joint_acceleration_radps2: 5")
    summary = json.loads(deltactl("check", "fast.yaml", "--json").stdout)
    assert summary["slower"]["asked_mps"] == 6.28
    top_mps = summary["slower"]["top_mps"]
    assert summary["mean_speed_mps"] < top_mps < 1.0
    said = f"it gets to {top_mps:.3g} m/s at most, because of joint_acceleration_radps2 5"
    assert said in deltactl("check", "fast.yaml").stderr
    assert said in deltactl("run", "fast.yaml", "--simulate").stderr


@pytest.mark.parametrize(
    ("more", "limit"),
    [
        (", joint_speed_radps: 0.1", "joint_speed_radps 0.1"),
        ("", ""),
    ],
)
def test_the_limit_that_holds_is_named(
    deltactl: Deltactl, tmp_path: Path, more: str, limit: str
) -> None:
    """And nothing where the speed is reached."""
    _job(tmp_path, 0.05, more)
    said = deltactl("check", "fast.yaml").stderr
    assert (f"because of {limit}" in said) if limit else ("never reached" not in said)
