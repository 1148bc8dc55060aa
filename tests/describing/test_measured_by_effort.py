"""`init axis --measure`: what an effort moves and holds, of drawn axes."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.describing.measured import moved_by_effort
from deltactl.models.robot import ServoAxis
from deltactl.models.robot_files import load_with_effects
from deltactl.recording.tables.flat import FlatRecording, from_columns

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
INERTIA, HANGS_RAD = 0.02, 0.4


def swung(weight: float, step_s: float = 0.004, counts: int = 16384) -> FlatRecording:
    """An axis with friction, and a weight on it or none, seen by an encoder."""
    rng = np.random.default_rng(round(1e3 * weight) + counts)
    t_s = step_s * np.arange(round(30.0 / step_s))
    waves = ((0.8, 0.8), (0.5, 2.1), (0.25, 4.7))
    angle = sum(size * np.sin(rate * t_s + rng.uniform(0.0, 6.0)) for size, rate in waves)
    speed = np.gradient(angle, t_s)
    effort = INERTIA * np.gradient(speed, t_s) + 0.02 * np.tanh(speed / 0.02) + 0.01 * speed
    effort += weight * np.sin(angle - HANGS_RAD) + 0.004 * rng.standard_normal(len(t_s))
    step = 2.0 * np.pi / counts
    columns = {"t": t_s, "position": step * np.round(angle / step), "effort": effort}
    return from_columns(columns, "swing", range(len(t_s)))


@pytest.mark.parametrize(("step_s", "counts"), [(0.004, 16384), (0.001, 4096), (0.001, 1000)])
@pytest.mark.parametrize("weight", [0.0, 0.1, 0.9])
def test_inertia_and_weight_of_an_axis(step_s: float, counts: int, weight: float) -> None:
    """At 1 kHz steps of an encoder are most of a speed: the inertia was a tenth of what it is."""
    moved = moved_by_effort(swung(weight, step_s, counts))
    assert moved is not None
    assert moved.inertia == pytest.approx(INERTIA, rel=0.1)
    assert moved.weight == pytest.approx(weight, rel=0.05, abs=1e-9)
    if weight:
        assert moved.hangs_rad == pytest.approx(HANGS_RAD, abs=0.05)


def test_a_slide_has_no_weight_that_hangs() -> None:
    moved = moved_by_effort(swung(0.9), turns=False)
    assert moved is None or not moved.weight


def test_a_measured_weight_is_in_the_robot_file_unless_one_is_given(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    swing = swung(0.9)
    table = np.stack([swing.t_s, swing.column("position"), swing.column("effort")], axis=1)
    np.savetxt(tmp_path / "s.csv", table, "%.6f", ",", header="t,position,effort", comments="")
    words = ("--motion", "rotary", "--measure", "s.csv", "--effort-gain", "2", "--yes")
    deltactl("init", "axis", "found.yaml", *words)
    deltactl("init", "axis", "given.yaml", *words, "--hanging-nm", "1.5")
    found, given = (load_with_effects(tmp_path / f"{one}.yaml") for one in ("found", "given"))
    assert isinstance(found, ServoAxis)
    assert isinstance(given, ServoAxis)
    assert found.inertia == pytest.approx(2.0 * INERTIA, rel=0.05)
    assert found.gravity is not None
    assert found.gravity.torque_nm == pytest.approx(1.8, rel=0.05)
    assert found.gravity.zero_rad == pytest.approx(HANGS_RAD, abs=0.05)
    assert given.gravity is not None
    assert given.gravity.torque_nm == 1.5
