"""The servo robot through the real command line, alone and through its daemon."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.flat_files import read_flat
from tests.rigs.in_process import called

TEXT = (CONFIG_FOLDER / "uzunovic-2013.yaml").read_text(encoding="utf-8")
JOB = """name: little
robot: {robot}
path:
  {{shape: circle, centre_m: [0, 0, -0.075], radius_m: 0.003, turns: {turns}, spacing_m: 0.0001}}
timing: {{mode: accelerated, speed_mps: 0.01}}
inverse_kinematics: {{kind: network, file: uzunovic-2013.tflite}}
"""
LOST = "as_built: {servo: {faults: [{kind: encoder_lost, joint: 2, at_s: %s, lasts_s: 1.0}]}}\n"
COMMAND = [sys.executable, "-m", "deltactl.cli.main"]

Deltactl = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def deltactl(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Deltactl:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))

    def run(*words: str, status: int = 0) -> subprocess.CompletedProcess[str]:
        done = called(words, capfd)
        assert done.returncode == status, (done.stdout, done.stderr)
        return done

    return run


def files(folder: Path, more: str = "", turns: int = 1) -> tuple[str, str]:
    robot, job = folder / "micro.yaml", folder / "little.yaml"
    robot.write_text(TEXT + more, encoding="utf-8")
    job.write_text(JOB.format(robot=robot, turns=turns), encoding="utf-8")
    return str(robot), str(job)


def test_a_run_reports_and_exports(deltactl: Deltactl, tmp_path: Path) -> None:
    _, job = files(tmp_path)
    done = deltactl("run", job, "--simulate", "--json", "--record", "r.mcap", "--report", "r.html")
    result = json.loads(done.stdout)
    assert result["outcome"] == "done"
    assert all(result["tracking"]["simulated truth"][axis]["max_m"] < 3e-4 for axis in "xyz")
    assert "Servo drives" in (tmp_path / "r.html").read_text()
    deltactl("export", "r.mcap", "r.csv.gz")
    table = read_flat(tmp_path / "r.csv.gz")
    assert table.has("theta_1", "theta_3", "current_2", "command_3", "disturbance_1", "range_x")
    assert np.median(np.diff(table.t_s)) == pytest.approx(0.002)


def test_a_lost_encoder_ends_the_run_in_one_line(deltactl: Deltactl, tmp_path: Path) -> None:
    _, job = files(tmp_path, LOST % 1.5)
    done = deltactl("run", job, "--simulate", "--record", "lost.mcap", status=2)
    assert "ended as fault: the encoder signal of motor2 is lost; check its cable" in done.stderr
    assert "Traceback" not in done.stderr
    run = read_run(tmp_path / "lost.mcap")
    assert run.complete
    assert [event.kind for event in run.events].count("fault") == 1


@pytest.mark.study
@pytest.mark.realtime
def test_after_a_lost_encoder_the_daemon_refuses_until_cleared_and_homed(
    deltactl: Deltactl, tmp_path: Path
) -> None:
    robot, job = files(tmp_path, LOST % 5.0, turns=40)
    socket = str(tmp_path / "d.sock")
    words = [*COMMAND, "service", "daemon", robot, "--simulate", "--socket", socket]
    daemon = subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.DEVNULL)
    try:
        _wait(lambda: Path(socket).exists())
        deltactl("power", "on", "--socket", socket)
        deltactl("home", "--socket", socket)
        lost = deltactl("run", job, "--socket", socket, status=2)
        assert "encoder signal of motor2 is lost" in lost.stderr
        status = json.loads(deltactl("status", "--json", "--socket", socket).stdout)
        assert status["state"] == "fault"
        refused = deltactl("run", job, "--socket", socket, status=2)
        assert "the robot is in a fault (the encoder signal of motor2 is lost" in refused.stderr
        time.sleep(1.0)  # after which the cable is back
        deltactl("acknowledge", "--socket", socket)
        unhomed = deltactl("run", job, "--socket", socket, status=2)
        assert "the robot is unhomed" in unhomed.stderr
    finally:
        daemon.terminate()
        assert daemon.wait(20.0) == 0


def _wait(until: Callable[[], bool], seconds: float = 30.0) -> None:
    give_up_s = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < give_up_s
        time.sleep(0.05)
