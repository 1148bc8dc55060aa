"""What has to reach the disk is synced, and the disk is not filled to the brim."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path

import pytest

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing import append_file, spool
from deltactl.recording.writing.append_file import AppendFile
from deltactl.recording.writing.writer import RunRecorder

START_NS = 5_000_000_000


@pytest.fixture
def synced(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sizes of the files at each fdatasync."""
    sizes: list[int] = []
    real = os.fdatasync

    def noted(descriptor: int) -> None:
        sizes.append(os.fstat(descriptor).st_size)
        real(descriptor)

    monkeypatch.setattr(append_file.os, "fdatasync", noted)
    return sizes


def wait(condition, limit_s: float = 30.0) -> None:
    give_up_s = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < give_up_s
        time.sleep(0.01)


def test_a_sync_reaches_the_kernel(tmp_path: Path, synced: list[int]) -> None:
    file = AppendFile(tmp_path / "a")
    file.append(b"1234")
    file.sync()
    assert synced == [4]
    file.close()


def test_a_write_that_failed_half_way_leaves_no_half_piece(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is written once there is room again follows what stood before."""
    file = AppendFile(tmp_path / "a")
    file.append(b"before ")
    whole, told = os.write, [3]

    def full(descriptor: int, data: memoryview) -> int:
        if not told:
            raise OSError(errno.ENOSPC, "No space left on device")
        return whole(descriptor, data[: told.pop()])

    with monkeypatch.context() as full_disk:
        full_disk.setattr(append_file.os, "write", full)
        with pytest.raises(OSError, match="No space left"):
            file.append(b"lost in the middle")
    assert (tmp_path / "a").read_bytes() == b"before "
    file.append(b"and after")
    assert (tmp_path / "a").read_bytes() == b"before and after"
    assert file.size == len(b"before and after")
    file.close()


def test_the_folder_of_a_recording_is_made_and_one_that_somebody_deleted_is_gone(
    tmp_path: Path,
) -> None:
    file = AppendFile(tmp_path / "new" / "folder" / "a")
    file.path.unlink()
    file.discard()
    assert list(file.path.parent.iterdir()) == []


def test_a_recording_is_synced_while_it_grows(
    tmp_path: Path, synced: list[int], configuration: RunConfiguration, monkeypatch
) -> None:
    for name in ("SYNC_S", "BLOCK_AGE_S", "POLL_S"):
        monkeypatch.setattr(spool, name, 0.05)
    path = tmp_path / "run.mcap"
    recorder = RunRecorder(path, configuration, start_ns=START_NS, counts=(0, 0, 0))
    for number in range(5):
        seen = len(synced)
        recorder.event(START_NS + number * 2_000_000_000, "note", f"number {number}")
        wait(lambda seen=seen: len(synced) > seen)
    size = path.stat().st_size
    recorder.close()
    assert synced[-2] <= size
    assert synced == sorted(synced)


def test_none_is_begun_on_a_disk_that_is_nearly_full(
    tmp_path: Path, configuration: RunConfiguration
) -> None:
    with pytest.raises(RecordingError, match=r"must stay free; delete old recordings"):
        RunRecorder(
            tmp_path / "run.mcap",
            configuration,
            start_ns=START_NS,
            counts=(0, 0, 0),
            reserve_bytes=2**62,
        )
    assert not list(tmp_path.iterdir())


def test_one_that_runs_ends_before_the_disk_is_full(
    tmp_path: Path, configuration: RunConfiguration, monkeypatch
) -> None:
    monkeypatch.setattr(spool, "SYNC_S", 0.05)
    path = tmp_path / "run.mcap"
    recorder = RunRecorder(path, configuration, start_ns=START_NS, counts=(0, 0, 0))
    recorder.event(START_NS, "note", "there is room")
    monkeypatch.setattr(AppendFile, "free_bytes", lambda self: self.reserve_bytes - 1)
    recorder.event(START_NS + 2_000_000_000, "note", "there is none")
    recorder.event(START_NS + 4_000_000_000, "note", "there is none")
    wait(lambda: recorder.failed != "")
    assert "64 MiB must stay free on this disk" in recorder.failed
    recorder.close()
