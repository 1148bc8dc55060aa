"""Whole runs through the real command line, on the simulated robot."""

from __future__ import annotations

import json
import re
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from deltactl.cli.main import app
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.flat_files import read_flat
from tests.rigs.started import started


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


@pytest.fixture(scope="module")
def circle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording of a run of a small circle, which only reads of it share."""
    folder = tmp_path_factory.mktemp("circle")
    path = folder / "c.mcap"
    words = ("run", str(small_circle(folder)), "--simulate", "--record", str(path))
    assert CliRunner().invoke(app, words).exit_code == 0
    return path


def small_circle(folder: Path, robot: str = "zhao-2023.yaml") -> Path:
    """The shipped circle with a fifth of its radius, as a job in this folder."""
    text = (CONFIG_FOLDER / "circle.yaml").read_text(encoding="utf-8")
    job = folder / "small.yaml"
    job.write_text(text.replace("radius_m: 0.1", "radius_m: 0.02").replace("zhao-2023.yaml", robot))
    return job


@pytest.mark.study
def test_a_run_exports_to_the_contracts_columns(deltactl, circle: Path, tmp_path: Path) -> None:
    deltactl("export", str(circle), "c.csv")
    table = read_flat(tmp_path / "c.csv")
    assert table.has("steps_1", "range_x", "range_y", "range_z", "status_x", "t_pwm")
    assert np.median(np.diff(table.t_s)) == 0.02 or abs(np.median(np.diff(table.t_s)) - 0.02) < 1e-3


@pytest.mark.study
def test_the_same_run_twice_is_the_same(deltactl, circle: Path, tmp_path: Path) -> None:
    deltactl("run", str(small_circle(tmp_path)), "--simulate", "--record", "again.mcap")
    for name, recording in (("a", str(circle)), ("b", "again.mcap")):
        deltactl("export", recording, f"{name}.csv", "--truth")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_a_simulated_robot_that_sees_nothing_runs_unasked(deltactl, tmp_path: Path) -> None:
    """Nobody can look at its arms; the option that accepts them unseen does no harm."""
    blind = re.sub(
        r"^(sensors|ranging):.*\n(?:  .*\n|\n(?=  ))+", "",
        (CONFIG_FOLDER / "zhao-2023.yaml").read_text(), flags=re.MULTILINE,
    )  # fmt: skip
    (tmp_path / "blind.yaml").write_text(blind)
    job = small_circle(tmp_path, "blind.yaml")
    for said in ((), ("--accept-unseen", "80")):
        ran = deltactl("run", str(job), "--simulate", *said, "--json")
        assert json.loads(ran.stdout)["outcome"] == "done"
        assert "look whether each arm" not in ran.stdout + ran.stderr


def test_check_says_what_a_job_would_do(deltactl) -> None:
    summary = json.loads(deltactl("check", "spiral.yaml", "--json").stdout)
    assert summary["duration_s"] > 1.0
    assert max(summary["peak_step_rate_hz"]) <= 1.0 / 0.006 + 1.0


@pytest.mark.study
def test_report_draws_a_recording(deltactl, circle: Path, tmp_path: Path) -> None:
    done = deltactl("report", str(circle), "-o", "c.html")
    assert "measured" in done.stdout
    assert (tmp_path / "c.html").stat().st_size > 10_000


def test_the_sensors_alone_are_recorded(deltactl, tmp_path: Path) -> None:
    deltactl("status", "record", "still.mcap", "--seconds", "4")
    deltactl("export", "still.mcap", "still.csv")
    table = read_flat(tmp_path / "still.csv")
    assert 190 <= len(table) <= 205
    assert abs(np.nanmean(table.column("range_x")) - 0.6) < 0.001


@pytest.mark.parametrize("word", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_decelerates_and_ends(tmp_path: Path, word: int) -> None:
    """On the virtual clock the robot's loops run within the wait: a signal must not end them."""
    text = (CONFIG_FOLDER / "heart.yaml").read_text(encoding="utf-8")
    (tmp_path / "long.yaml").write_text(text.replace("repeats: 1", "repeats: 500"))
    recording = tmp_path / "long.mcap"
    run = started("run", "long.yaml", "--simulate", "--record", recording, cwd=tmp_path)
    while not recording.exists() or recording.stat().st_size < 200_000:
        assert run.poll() is None
        time.sleep(0.02)
    run.send_signal(word)
    table, said = run.communicate(timeout=60.0)
    assert run.returncode == 2
    assert "ended as cancelled" in said
    assert "The path was not run to its end: errors are of the" in table
    assert read_run(recording).complete
