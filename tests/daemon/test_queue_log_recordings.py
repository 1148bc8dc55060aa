"""What the page asks of the daemon beside moving: order of the queue, log, names of recordings."""

from __future__ import annotations

import fcntl
import logging
from pathlib import Path

import pytest

from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.daemon.log_lines import KEPT, LogLines
from deltactl.firmware_py.daemon.protocol import MAX_LINE_BYTES, encode
from deltactl.foundation.errors import NotReady, RecordingError, ServiceError
from deltactl.recording.writing.retention import delete, rename
from deltactl.web.motion_card import to_point
from tests.rigs.served import served


@pytest.mark.study
def test_a_waiting_job_takes_another_place_and_no_other_job_does(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO, "deltactl")
    with served(tmp_path) as robot, Client(robot.socket) as client:
        at = client.status().position_m
        assert at is not None
        far = (at[0], at[1], at[2] - 0.05)
        numbers = [client.submit_text(to_point("mine.yaml", far, "a"), "j")]
        client.pause()  # so that none ends meanwhile; the first may have begun
        numbers += [client.submit_text(to_point("mine.yaml", at, name), "j") for name in "bcd"]
        for place, order in ((1, "dbc"), (100, "bcd")):
            client.move(numbers[3], place)
            assert "".join(client.status().queued).replace("a", "") == order
        assert client.status().queued[-1] == "d"
        with pytest.raises(NotReady, match="does not wait"):
            client.move(99, 1)
        with pytest.raises(ServiceError, match="needs a 'job_id' and a 'place'"):
            client._ask("move", job_id=numbers[1])
        client.stop("enough")
        lines = client.log()
        assert any("stop enough asked for" in line["text"] for line in lines)
        assert client.log(after=lines[-1]["number"]) == []


def record(log: LogLines, text: str) -> None:
    log.handle(logging.LogRecord("deltactl.x", logging.WARNING, "", 0, text, None, None))


def test_the_log_is_bounded_and_numbered_and_printable() -> None:
    log = LogLines()
    for number in range(KEPT + 50):
        record(log, f"line {number}\x1b[31m")
    newest = log.after(0)
    assert [line["number"] for line in newest][-3:] == [KEPT + 48, KEPT + 49, KEPT + 50]
    assert newest[-1]["text"].startswith(f"line {KEPT + 49}")
    assert newest[-1]["text"].isprintable()
    assert newest[-1]["level"] == "warning"
    assert [line["number"] for line in log.after(KEPT + 48)] == [KEPT + 49, KEPT + 50]
    assert log.after(10**9) == newest, "a number from before a restart"
    for _ in range(KEPT):
        record(log, "\u20ac" * 5000)
    for number in (0, KEPT + 51):
        assert log.after(number)
        assert len(encode({"id": 1, "lines": log.after(number)})) < MAX_LINE_BYTES


def test_a_recording_is_renamed_and_deleted_and_nothing_else_is(tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()
    for name in ("a.mcap", "b.mcap", "open.mcap"):
        (folder / name).write_text(name)
    (tmp_path / "outside.mcap").write_text("outside")
    (folder / "link.mcap").symlink_to(tmp_path / "outside.mcap")
    assert rename(folder, "a.mcap", "first run").name == "first run.mcap"
    assert (folder / "first run.mcap").read_text() == "a.mcap"
    assert not (folder / "a.mcap").exists()
    with pytest.raises(RecordingError, match="there is such a recording already"):
        rename(folder, "first run.mcap", "b.mcap")
    for name in ("../outside.mcap", "/etc/passwd", ".hidden", "x\ny"):
        with pytest.raises(RecordingError, match="plain name"):
            rename(folder, "b.mcap", name)
        with pytest.raises(RecordingError, match="plain name"):
            delete(folder, name)
    for name in ("link.mcap", "none.mcap"):
        with pytest.raises(RecordingError):
            delete(folder, name)
    with (folder / "open.mcap").open() as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        with pytest.raises(RecordingError, match="is being recorded"):
            delete(folder, "open.mcap")
        with pytest.raises(RecordingError, match="is being recorded"):
            rename(folder, "open.mcap", "x")
    delete(folder, "b.mcap")
    kept = {"first run.mcap", "open.mcap", "link.mcap"}
    assert {path.name for path in folder.iterdir()} == kept
    assert (tmp_path / "outside.mcap").read_text() == "outside"
