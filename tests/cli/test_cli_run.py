"""Whole runs through the real command line, on the simulated robot."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from recording.reading.reader import read_run
from recording.tables.flat_files import read_flat


def test_the_heart_runs_and_everything_agrees(deltactl, tmp_path: Path) -> None:
    done = deltactl(
        "run", "heart.yaml", "--simulate", "--json", "--record", "h.mcap", "--report", "h.html"
    )
    result = json.loads(done.stdout)
    assert result["outcome"] == "done"
    truth = result["tracking"]["simulated truth"]
    assert all(truth[axis]["rms_m"] < 0.0002 for axis in "xyz")
    measured = result["tracking"]["measured"]
    assert all(0.001 < measured[axis]["rms_m"] < 0.002 for axis in "xyz")  # 1.5 mm of noise
    run = read_run(tmp_path / "h.mcap")
    assert run.complete
    assert run.edges.counts[-1].tolist() == run.targets.steps[-1].tolist()
    assert "The path from above" in (tmp_path / "h.html").read_text()


def test_a_run_exports_to_the_contracts_columns(deltactl, tmp_path: Path) -> None:
    deltactl("run", "circle.yaml", "--simulate", "--record", "c.mcap")
    deltactl("export", "c.mcap", "c.csv")
    table = read_flat(tmp_path / "c.csv")
    assert table.has("steps_1", "range_x", "range_y", "range_z", "status_x", "t_pwm")
    assert np.median(np.diff(table.t_s)) == 0.02 or abs(np.median(np.diff(table.t_s)) - 0.02) < 1e-3


def test_the_same_run_twice_is_the_same(deltactl, tmp_path: Path) -> None:
    for name in ("a", "b"):
        deltactl("run", "circle.yaml", "--simulate", "--record", f"{name}.mcap")
        deltactl("export", f"{name}.mcap", f"{name}.csv", "--truth")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_check_says_what_a_job_would_do(deltactl) -> None:
    summary = json.loads(deltactl("check", "spiral.yaml", "--json").stdout)
    assert summary["duration_s"] > 1.0
    assert max(summary["peak_step_rate_hz"]) <= 1.0 / 0.006 + 1.0


def test_report_draws_a_recording(deltactl, tmp_path: Path) -> None:
    deltactl("run", "circle.yaml", "--simulate", "--record", "c.mcap")
    done = deltactl("report", "c.mcap", "-o", "c.html")
    assert "measured" in done.stdout
    assert (tmp_path / "c.html").stat().st_size > 10_000


def test_the_sensors_alone_are_recorded(deltactl, tmp_path: Path) -> None:
    deltactl("record", "still.mcap", "--seconds", "4")
    deltactl("export", "still.mcap", "still.csv")
    table = read_flat(tmp_path / "still.csv")
    assert 190 <= len(table) <= 205
    assert abs(np.nanmean(table.column("range_x")) - 0.6) < 0.001
