"""A job whose recording cannot be begun is refused with the reason, in the result and the log."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.controller import Controller
from deltactl.recording.writing.append_file import AppendFile
from tests.controller.conftest import Finish, WriteJob


def test_the_reason_is_in_the_result_and_in_the_log(
    homed: Controller,
    write_job: WriteJob,
    finish: Finish,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.INFO)
    (tmp_path / "taken").write_text("no folder")
    result = finish(homed, homed.submit(write_job(), tmp_path / "taken" / "run.mcap"))
    assert result.outcome == "refused"
    assert str(tmp_path / "taken") in result.why
    assert "File exists" in result.why
    assert result.recording is None
    said = [one.getMessage() for one in caplog.records if result.why in one.getMessage()]
    assert len(said) == 1
    assert "refused" in said[0]
    assert homed.status().state == "ready"
    again = finish(homed, homed.submit(write_job(), tmp_path / "run.mcap"))
    assert (again.outcome, again.recording) == ("done", str(tmp_path / "run.mcap"))
    assert not any("done" in one.getMessage() for one in caplog.records)


def test_a_file_that_is_there_is_named(
    homed: Controller, write_job: WriteJob, finish: Finish, tmp_path: Path
) -> None:
    taken = tmp_path / "run.mcap"
    number = homed.submit(write_job(), taken)
    AppendFile(taken).close()  # it comes while the job waits
    result = finish(homed, number)
    assert result.outcome == "refused"
    assert str(taken) in result.why
    assert result.recording is None
    assert taken.exists()


def test_a_run_that_is_broken_off_keeps_its_recording(
    homed: Controller, write_job: WriteJob, finish: Finish, tmp_path: Path
) -> None:
    number = homed.submit(write_job(), tmp_path / "run.mcap")
    while homed.status().state != "running":
        homed.clock.sleep_until_ns(homed.clock.now_ns() + 1_000_000)
    homed.stop("enough")
    result = finish(homed, number)
    assert (result.outcome, result.recording) == ("stopped", str(tmp_path / "run.mcap"))
