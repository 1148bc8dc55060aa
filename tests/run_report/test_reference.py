"""Errors are measured from what was asked for: at rests, on ramps, and on no way back."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.run_report.reference import arrivals, targets_at, windows
from deltactl.recording.reading.reader import read_run
from tests.cli.conftest import deltactl as deltactl

SIZES = (
    "--base-radius-mm", "95", "--platform-radius-mm", "35", "--upper-arm-mm", "110",
    "--forearm-mm", "260", "--microsteps-per-rev", "3200", "--gear-ratio", "4",
)  # fmt: skip
MICROSTEP_M = 0.08e-3
"""Half a microstep moves the platform by up to so much; it is where nothing is wrong."""
LEGS = {
    "a dwell": "{to_m: [0.03, 0.0, -0.287], dwell_s: 0.2}, {to_m: [0.03, 0.03, -0.28]}",
    "a corner": "{to_m: [0.03, 0.0, -0.287]}, {to_m: [0.03, 0.03, -0.28]}",
}


def job(legs: str, repeats: int, timing: str, spacing_m: float) -> str:
    return (
        "name: legs\nrobot: printed.yaml\n"
        f"path: {{shape: way, start_m: [0.0, 0.0, -0.287], spacing_m: {spacing_m},"
        f" legs: [{legs}]}}\n"
        f"timing: {{{timing}}}\nrepeats: {repeats}\ninverse_kinematics: {{kind: geometry}}\n"
    )


@pytest.mark.parametrize("spacing_m", [0.0005, 0.004])
@pytest.mark.parametrize(
    "timing", ["mode: accelerated, speed_mps: 0.1", "mode: together, t_pwm_s: 0.002"]
)
@pytest.mark.parametrize("legs", LEGS)
def test_a_run_without_faults_errs_by_a_microstep(
    deltactl, tmp_path: Path, legs: str, timing: str, spacing_m: float
) -> None:
    """It was asked to stand at a rest, to speed up from it, and nothing on the way back."""
    deltactl("init", "delta", "printed.yaml", *SIZES, "--sensors", "none")
    (tmp_path / "legs.yaml").write_text(job(LEGS[legs], 3, timing, spacing_m))
    words = ("run", "legs.yaml", "--simulate", "--json", "--record", "r.mcap")
    result = json.loads(deltactl(*words).stdout)
    truth = result["tracking"]["simulated truth"]
    # Between targets far apart arms move in proportion, and the platform on an arc.
    allowed_m = MICROSTEP_M if spacing_m < 0.001 else 3 * MICROSTEP_M
    assert max(truth[axis]["max_m"] for axis in "xyz") < allowed_m
    run = read_run(tmp_path / "r.mcap")
    assert arrivals(run).sum() == result["tracking"]["commanded"]["x"]["samples"]


@pytest.mark.study
def test_the_last_target_counts_though_its_last_step_comes_before(deltactl, tmp_path: Path) -> None:
    deltactl("init", "delta", "printed.yaml", *SIZES, "--sensors", "none")
    result = json.loads(deltactl("run", "printed-circle.yaml", "--simulate", "--json").stdout)
    truth = result["tracking"]["simulated truth"]
    assert max(truth[axis]["max_m"] for axis in "xyz") < MICROSTEP_M


def test_what_is_asked_for_stands_still_during_a_dwell(deltactl, tmp_path: Path) -> None:
    deltactl("init", "delta", "printed.yaml", *SIZES, "--sensors", "none")
    text = job(LEGS["a dwell"], 1, "mode: accelerated, speed_mps: 0.1", 0.0005)
    (tmp_path / "legs.yaml").write_text(text)
    deltactl("run", "legs.yaml", "--simulate", "--record", "r.mcap")
    run = read_run(tmp_path / "r.mcap")
    (window,) = windows(run)
    t_s = np.arange(window.start_ns, window.end_ns, 1_000_000) * 1e-9
    asked_m = targets_at(run, t_s)
    assert np.isfinite(asked_m).all()
    still = (np.abs(asked_m - [0.03, 0.0, -0.287]).max(axis=1) < 1e-9).sum()
    assert still == pytest.approx(200, abs=3)
