"""A daemon that works on files of 4 MB answers others at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.daemon.client import Client
from tests.rigs.large_requests import JOB, JOBS, MB, ROBOT_FILE, WRONG, daemon, measured

MEANWHILE_S = 0.2


@pytest.mark.realtime
def test_stop_status_and_acknowledge_while_large_files_are_read(tmp_path: Path) -> None:
    robot, job = tmp_path / "robot.yaml", tmp_path / "job.yaml"
    robot.write_text(ROBOT_FILE.read_text() + WRONG["names near a key"](4 * MB))
    job.write_text(JOB + JOBS["wrong poses"](4 * MB))
    with daemon(tmp_path) as socket:
        for do, path in (("home", robot), ("run", job)):
            found = measured(socket, do, path)
            assert found.refusal
            assert set(found.meanwhile_s) == {"status", "stop", "acknowledge"}
            assert max(found.meanwhile_s.values()) < MEANWHILE_S, found.meanwhile_s
        with Client(socket) as client:
            assert client.status().state != "fault"
