"""A computer that stands still for a moment, as the heartbeat allows: the job goes on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.named_files import CONFIG_FOLDER

START_S, END_S = 60.0, 60.0
HEARTBEAT_S, PAUSE_S, MOVES_S = 5.0, 1.5, 3.0
"""The pause is three times what a robot may be blind, and the robot moves before it."""
CIRCLE = """name: circle
robot: {robot}
path: {{shape: circle, centre_m: [0, 0, -0.45], radius_m: 0.05, turns: 2}}
timing: {{mode: accelerated, speed_mps: 0.1}}
inverse_kinematics: {{kind: geometry}}
"""


@pytest.mark.realtime
def test_a_job_outlives_a_pause_that_the_heartbeat_allows(tmp_path: Path) -> None:
    """Nobody read the sensors meanwhile: that is no blindness of theirs."""
    robot, job, socket = (tmp_path / name for name in ("mine.yaml", "circle.yaml", "d.sock"))
    text = (CONFIG_FOLDER / "zhao-2023.yaml").read_text(encoding="utf-8")
    beat = f"heartbeat_s: {HEARTBEAT_S}\n  backend: pulse"
    robot.write_text(text.replace("backend: pulse", beat))
    job.write_text(CIRCLE.format(robot=robot))
    words = ("service", "daemon", robot, "--simulate", "--socket", socket, "--recordings", tmp_path)
    daemon = subprocess.Popen(
        [sys.executable, "-m", "deltactl.cli.main", *map(str, words)],
        cwd=tmp_path,
        env=os.environ | {"STATE_DIRECTORY": str(tmp_path)},
    )
    try:
        give_up_s = time.monotonic() + START_S
        while not socket.exists():
            assert daemon.poll() is None, "it did not start"
            assert time.monotonic() < give_up_s, "it did not start"
            time.sleep(0.1)
        with Client(socket) as client:
            client.power_on()
            client.home()
            number = client.submit(job, None)
            time.sleep(MOVES_S)
            assert client.status().state == "running"
            daemon.send_signal(signal.SIGSTOP)
            time.sleep(PAUSE_S)
            daemon.send_signal(signal.SIGCONT)
            give_up_s = time.monotonic() + END_S
            while (result := client.result(number)) is None and time.monotonic() < give_up_s:
                time.sleep(0.1)
            assert result is not None
            assert (result.outcome, result.why) == ("done", "")
    finally:
        daemon.send_signal(signal.SIGCONT)
        daemon.terminate()
        daemon.wait()
