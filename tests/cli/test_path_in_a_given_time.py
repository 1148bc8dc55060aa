"""`timing.duration_s`: a path takes as long as was said, or is refused with the shortest time."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
CONFIG = Path(__file__).parents[2] / "config"
CIRCLE = "{shape: circle, centre_m: [0, 0, -0.45], radius_m: 0.03}"
POINTS = (
    "{shape: points, dwell_s: 0.2, points_m: [[0, 0, -0.45], [0.03, 0, -0.45], [0, 0.03, -0.4]]}"
)
ANGLES = "{shape: joints, dwell_s: 0.2, angles_deg: [[30, 30, 30], [40, 45, 50]]}"


def _job(folder: Path, timing: str, what: str) -> None:
    (folder / "job.yaml").write_text(
        f"name: job\nrobot: {CONFIG / 'zhao-2023.yaml'}\n{what}\n"
        f"timing: {{mode: accelerated, {timing}}}\ninverse_kinematics: {{kind: geometry}}\n"
    )


@pytest.mark.parametrize("path", [CIRCLE, POINTS, ANGLES])
def test_it_takes_as_long_as_was_said(deltactl: Deltactl, tmp_path: Path, path: str) -> None:
    _job(tmp_path, "duration_s: 4", f"path: {path}")
    summary = json.loads(deltactl("check", "job.yaml", "--json").stdout)
    at_first_s = 0.2 if "dwell" in path else 0.0
    takes_s = summary["duration_s"] - summary["approach_s"] - at_first_s
    assert takes_s == pytest.approx(4.0, rel=2e-3)
    assert summary["timing"] == "accelerated, 4 s"
    assert summary["slower"] is None


def test_repeats_take_so_long_each(deltactl: Deltactl, tmp_path: Path) -> None:
    _job(tmp_path, "duration_s: 4", f"path: {CIRCLE}\nrepeats: 3")
    summary = json.loads(deltactl("check", "job.yaml", "--json").stdout)
    assert summary["duration_s"] - summary["approach_s"] == pytest.approx(12.0, rel=2e-3)


def test_too_short_names_the_shortest_which_then_does(deltactl: Deltactl, tmp_path: Path) -> None:
    _job(tmp_path, "duration_s: 0.05", f"path: {CIRCLE}")
    said = deltactl("check", "job.yaml", status=2).stderr
    found = re.search(r"job\.yaml.*takes ([\d.]+) s at the fastest", said)
    assert found is not None, said
    _job(tmp_path, f"duration_s: {found[1]}", f"path: {CIRCLE}")
    deltactl("check", "job.yaml")


@pytest.mark.parametrize(
    ("timing", "what", "words"),
    [
        ("duration_s: 4, speed_mps: 0.1", f"path: {CIRCLE}", "either 'speed_mps' or 'duration_s'"),
        ("joint_speed_radps: 1", f"path: {CIRCLE}", "either 'speed_mps' or 'duration_s'"),
        ("duration_s: 4", f"steps: [{{path: {CIRCLE}}}]", "a job of steps needs speed_mps"),
    ],
)
def test_what_is_refused(
    deltactl: Deltactl, tmp_path: Path, timing: str, what: str, words: str
) -> None:
    _job(tmp_path, timing, what)
    assert words in deltactl("check", "job.yaml", status=2).stderr
