"""Dates, turns per second, and the options that are printed where a heading names a wrong unit."""

from __future__ import annotations

import re
import shlex
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.mapping import load_mapping
from deltactl.recording.foreign.reading import read_mapped
from tests.rigs.in_process import called
from tests.rigs.owners_words import owner_says

N = 400
T_S = 0.05 * np.arange(N)
WAVE = np.sin(0.7 * T_S) + 0.2 * np.sin(1.9 * T_S)
SPEED = 0.7 * np.cos(0.7 * T_S) + 0.38 * np.cos(1.9 * T_S)


def write(path: Path, heading: str, *columns: np.ndarray) -> Path:
    np.savetxt(path, np.stack(columns, axis=1), "%.6g", ",", header=heading, comments="")
    return path


def options_of(path: Path) -> list[str]:
    return owner_says(inspect(path))


@pytest.mark.parametrize("heading", ["timestamp", "date", "when", "time_ms"])
@pytest.mark.parametrize("step_s", [1, 60, 3600])
def test_dates_in_whole_seconds_are_in_seconds(tmp_path: Path, heading: str, step_s: int) -> None:
    begin = datetime(2026, 3, 1, 10)
    rows = [
        f"{begin + timedelta(seconds=step_s * n)},{40 * one:.4f},{40 * WAVE[max(n - 10, 0)]:.4f}"
        for n, one in enumerate(WAVE)
    ]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([f"{heading},goal_deg,present_deg", *rows]) + "\n")
    read = read_mapped(path, load_mapping(None, options_of(path)))
    np.testing.assert_allclose(read.t_s - read.t_s[0], step_s * np.arange(N))
    assert not [one for one in inspect(path).warnings if one.startswith(heading)]


def test_a_velocity_in_turns_a_second_is_known_by_its_size(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", "t,pos_turns,vel_estimate,Iq", T_S, WAVE, SPEED, WAVE)
    options = options_of(path)
    assert "velocity=vel_estimate[turn/s]" in options
    read = read_mapped(path, load_mapping(None, options))
    np.testing.assert_allclose(read.columns["velocity"], 2.0 * np.pi * SPEED, atol=1e-4)


@pytest.mark.parametrize("factor", [3.3, 0.11])
def test_a_velocity_in_no_known_unit_is_left_out(tmp_path: Path, factor: float) -> None:
    path = write(tmp_path / "a.csv", "t,pos_deg,vel,Iq", T_S, WAVE, factor * SPEED, WAVE)
    found = inspect(path)
    assert not [one for one in found.options if one.startswith("velocity=")]
    assert [one for one in found.warnings if one.startswith("vel:")]


@pytest.mark.parametrize(
    ("heading", "size"), [("target_deg,actual_deg", 0.1), ("target_rad,actual_rad", 400.0)]
)
def test_a_hint_of_another_unit_can_be_typed(
    tmp_path: Path,
    heading: str,
    size: float,
    capsys: pytest.CaptureFixture[str],
) -> None:
    count_rad = 2.0 * np.pi / 4096.0
    read = count_rad * np.round(size * WAVE / count_rad)
    path = write(tmp_path / "a.csv", f"t,{heading}", T_S, size * WAVE, read)
    told: list[str] = []
    position = f"position={heading.split(',')[1]}"
    read_mapped(path, load_mapping(None, [position]), told.append)
    hints = re.findall(r'--set "(position=[^"]+)"', " ".join(told))
    assert hints
    for hint in hints:
        read_mapped(path, load_mapping(None, [hint]))
    made = called(["inspect", path, "--set", hints[0]], capsys)
    assert made.returncode == 0
    assert shlex.quote(hints[0]) in made.stdout, "it is printed as it was typed"
