"""A daemon that works on files of 4 MB answers in time, and others at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.daemon.client import Client
from tests.rigs.large_requests import (
    FOLLOWED_S,
    JOB,
    JOBS,
    MB,
    ROBOT_FILE,
    VALID,
    WRONG,
    daemon,
    measured,
)

MEANWHILE_S = 0.2
ANSWER_S = 2.0


@pytest.mark.study
@pytest.mark.realtime
def test_stop_status_and_acknowledge_while_large_files_are_read(tmp_path: Path) -> None:
    robot, job, right = (tmp_path / f"{name}.yaml" for name in ("robot", "job", "right"))
    robot.write_text(ROBOT_FILE.read_text() + WRONG["names near a key"](4 * MB))
    job.write_text(JOB + JOBS["wrong poses"](4 * MB))
    right.write_text(JOB + VALID["legs"](4 * MB))
    with daemon(tmp_path) as socket:
        for do, path in (("home", robot), ("run", job), ("run", right)):
            found = measured(socket, do, path, followed_s=ANSWER_S if path is right else FOLLOWED_S)
            # A robot file is read at a low priority: how fast is measured by the benchmark.
            assert do == "home" or found.answer_s < ANSWER_S
            assert found.refusal or path is right
            assert set(found.meanwhile_s) == {"status", "stop", "acknowledge"}
            assert max(found.meanwhile_s.values()) < MEANWHILE_S, found.meanwhile_s
        with Client(socket) as client:
            assert client.status().state != "fault"
