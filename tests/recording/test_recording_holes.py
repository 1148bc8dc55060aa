"""Sparse files: gigabytes of nothing are refused, or read up to there, at once."""

from __future__ import annotations

import os
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from mcap.writer import CompressionType, Writer

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.flat_files import is_own_run, read_flat
from deltactl.recording.tables.foreign_log import read_log
from deltactl.recording.writing.writer import RunRecorder

MS = 1_000_000
HOLE_BYTES = 4 * 2**30
AT_ONCE_S = 5.0
"""Records of nine zero bytes up to there would take minutes."""
MAGIC_BYTES = 8
PRIVATE = 0x80


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("hole") / "whole.mcap"
    with RunRecorder(path, RunConfiguration("robot", "job")) as recorder:
        for number in range(400):
            recorder.event(number * 20 * MS, "number", str(number))
    return path.read_bytes()


@pytest.fixture(scope="module")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A log of another program, in one chunk."""
    path = tmp_path_factory.mktemp("hole") / "foreign.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        writer.start(profile="", library="other")
        schema = writer.register_schema("Value", "jsonschema", b"{}")
        channel = writer.register_channel("/axis", "json", schema)
        for number in range(100):
            writer.add_message(channel, number * MS, b'{"position": 1.0}', number * MS)
        writer.finish()
    return path.read_bytes()


@contextmanager
def at_once() -> Iterator[None]:
    begun_s = time.process_time()  # however much of the processor others use
    yield
    assert time.process_time() - begun_s < AT_ONCE_S


def sparse(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    os.truncate(path, HOLE_BYTES)
    assert path.stat().st_blocks * 512 < HOLE_BYTES / 2
    return path


def test_a_recording_that_ends_in_a_hole_is_read_up_to_there(whole: bytes, tmp_path: Path) -> None:
    path = sparse(tmp_path / "cut.mcap", whole[: len(whole) // 2])
    with at_once():
        run = read_run(path)
        thinned = read_run(path, most_bytes=10_000)
    assert 0 < len(run.events) < 400
    assert not run.complete
    assert len(run.damage) == 1
    assert len(thinned.events) <= len(run.events)
    assert not thinned.complete


def test_what_follows_the_end_is_not_read(whole: bytes, tmp_path: Path) -> None:
    with at_once():
        run = read_run(sparse(tmp_path / "whole.mcap", whole))
    assert (len(run.events), run.complete, run.damage) == (400, True, ())


@pytest.mark.parametrize("read", [read_run, read_flat, read_log, is_own_run])
def test_nothing_but_a_hole_is_refused(
    whole: bytes, tmp_path: Path, read: Callable[[Path], object]
) -> None:
    path = sparse(tmp_path / "none.mcap", whole[:MAGIC_BYTES])
    with at_once():
        if read is is_own_run:
            assert not is_own_run(path)
        else:
            with pytest.raises(RecordingError, match=r"none\.mcap"):
                read(path)


def test_a_hole_in_a_log_of_another_program(foreign: bytes, tmp_path: Path) -> None:
    (tmp_path / "good.mcap").write_bytes(foreign)
    assert len(read_log(tmp_path / "good.mcap")["/axis.position"]) == 100
    # At the end of the data section, before the summary: a copy that was never finished.
    path = sparse(tmp_path / "cut.mcap", foreign[: len(foreign) // 3])
    with at_once(), pytest.raises(RecordingError, match=r"cut\.mcap"):
        read_log(path)


def test_records_that_nobody_looks_at_cost_nothing(whole: bytes, tmp_path: Path) -> None:
    """Attachments and records of other programs are passed over unread, holes or not."""
    path = tmp_path / "private.mcap"
    each = 2**27
    with path.open("wb") as out:
        out.write(whole[:MAGIC_BYTES])
        for _ in range(HOLE_BYTES // each):
            out.write(struct.pack("<BQ", PRIVATE, each))
            out.seek(each, os.SEEK_CUR)
        out.write(whole[MAGIC_BYTES:])
    with at_once():
        run = read_run(path)
    assert (len(run.events), run.complete) == (400, True)


@pytest.mark.study
def test_an_unpacked_chunk_that_is_empty_inside_is_left_out(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "chunk.mcap"
    size = 2**25
    body = struct.pack("<QQQII", 0, 0, size, 0, 0) + struct.pack("<Q", size)
    with path.open("wb") as out:
        out.write(whole[:MAGIC_BYTES])
        for _ in range(20):
            out.write(struct.pack("<BQ", 0x06, len(body) + size) + body)
            out.seek(size, os.SEEK_CUR)
        out.write(whole[MAGIC_BYTES:])
    with at_once():
        run = read_run(path)
    assert (len(run.events), len(run.damage)) == (400, 20)
