"""The program's own recordings and tables, looked at with `inspect`."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.tables.flat import BESIDE, UNITS, from_columns
from deltactl.recording.tables.flat_files import write_flat

Deltactl = Callable[..., subprocess.CompletedProcess[str]]
ROWS = 200


@pytest.mark.study
def test_a_run_and_its_table_are_diagnosed_as_they_are(deltactl: Deltactl, tmp_path: Path) -> None:
    circle = (CONFIG_FOLDER / "circle.yaml").read_text(encoding="utf-8")
    (tmp_path / "small.yaml").write_text(circle.replace("radius_m: 0.1", "radius_m: 0.03"))
    deltactl("run", "small.yaml", "--simulate", "--record", "run.mcap")
    deltactl("export", "run.mcap", "run.csv", "--truth")
    table = deltactl("inspect", "run.csv").stdout
    assert "diagnose run.csv --robot run-robot.yaml\n" in table
    run = deltactl("inspect", "run.mcap").stdout
    assert "this is a recording of deltactl" in run
    assert "deltactl diagnose run.mcap --robot ROBOT\n" in run
    assert "deltactl init" not in run


def test_columns_of_a_servo_run_are_what_they_are_called(tmp_path: Path) -> None:
    t_s = 0.02 * np.arange(ROWS)
    names = ["command", "theta", "current", "disturbance"]
    columns = {f"{name}_{motor}": np.sin(t_s + motor) for name in names for motor in (1, 2, 3)}
    columns |= {
        f"{name}_{axis}": 0.5 + 0.1 * np.cos(t_s) for name in ("range", "t") for axis in "xyz"
    }
    columns |= {f"status_{axis}": np.zeros(ROWS) for axis in "xyz"} | {"t_pwm": 0.006 + 0.0 * t_s}
    write_flat(from_columns({"t": t_s, **columns}, "run"), tmp_path / "run.csv")
    found = inspect(tmp_path / "run.csv")
    taken = {column: guess.name for column, guess in found.guesses.items()}
    assert taken == {name: name for name in ("t", *columns) if name in UNITS}
    assert not taken.keys() & BESIDE
    assert found.options == []


def test_the_current_of_a_lone_axis_is_its_effort(tmp_path: Path) -> None:
    t_s = 0.02 * np.arange(ROWS)
    asked = np.sin(t_s)
    table = np.stack([t_s, asked, np.roll(asked, 3), np.cos(t_s)], axis=1)
    heading = "t,command,position,current_1"
    np.savetxt(tmp_path / "axis.csv", table, "%.5f", ",", header=heading, comments="")
    assert inspect(tmp_path / "axis.csv").guesses["current_1"].name == "effort"


def test_empty_cells_are_counted_and_leave_the_rest_as_it_is(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    rows = [f"{0.02 * n:.2f},{n},{n if n % 4 else ''}" for n in range(ROWS)]
    (tmp_path / "axis.csv").write_text("\n".join(["t,command,position", *rows]) + "\n")
    shown = deltactl("inspect", "axis.csv").stdout
    assert f"empty cells: {ROWS // 4} of position" in shown
    (line,) = [line for line in shown.splitlines() if line.startswith("position ")]
    assert line.split()[-2:] == ["1", "199"] or "199" in line.split()
