"""Files that unpack to far more than they hold."""

from __future__ import annotations

import gzip
import tracemalloc
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap import records

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.scan import Scan
from deltactl.recording.tables import csv_table
from deltactl.recording.tables.csv_table import read_csv
from deltactl.recording.writing.container import record_bytes
from deltactl.recording.writing.retention import confined
from deltactl.recording.writing.writer import RunRecorder

MB = 2**20


def chunk(compression: str, packed: bytes, size: int) -> bytes:
    return record_bytes(
        records.Chunk(
            compression=compression,
            data=packed,
            message_start_time=0,
            message_end_time=0,
            uncompressed_crc=0,
            uncompressed_size=size,
        )
    )


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """A recording without its end, to which records can be added."""
    path = tmp_path / "r.mcap"
    with RunRecorder(path, RunConfiguration("robot", "job")) as recorder:
        recorder.event(0, "note", "text")
        recorder.flush()
        whole = path.read_bytes()
    path.write_bytes(whole)
    return path


@pytest.mark.parametrize("claimed", [1000, 300 * MB, 2**62])
@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_bomb_is_left_out(recording: Path, compression: str, claimed: int) -> None:
    zeros = bytes(256 * MB)
    packed = (
        zstandard.ZstdCompressor().compress(zeros)
        if compression == "zstd"
        else lz4.frame.compress(zeros)
    )
    del zeros
    with recording.open("ab") as file:
        file.write(chunk(compression, packed, claimed))
    tracemalloc.start()
    run = read_run(recording)
    _, most_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most_bytes < 8 * MB  # it was not unpacked
    assert [event.text for event in run.events] == ["text"]
    if claimed > 1000:
        assert any("unpacks to more" in line for line in run.damage)


def test_many_small_bombs_are_no_large_one(recording: Path) -> None:
    size = 4 * MB
    packed = zstandard.ZstdCompressor().compress(bytes(size))
    with recording.open("ab") as file:
        for _ in range(50):
            file.write(chunk("zstd", packed, size))
    scan = Scan(recording)
    for _ in scan.chunks():
        pass
    assert sum("unpacks to more" in line for line in scan.damage) > 40


def test_an_honest_chunk_is_read_up_to_its_size(recording: Path) -> None:
    body = b"\x00" * 9
    packed = zstandard.ZstdCompressor().compress(body)
    with recording.open("ab") as file:
        file.write(chunk("zstd", packed, len(body)))
    assert not any("unpacks" in line for line in read_run(recording).damage)


def test_a_table_may_not_unpack_without_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(csv_table, "_MOST_BYTES", MB)
    path = tmp_path / "x.csv.gz"
    path.write_bytes(gzip.compress(b"t,steps_1\n" + b"0,0\n" * MB))
    with pytest.raises(RecordingError, match="more than 1 MiB"):
        read_csv(path)


@pytest.mark.parametrize("wanted", ["r.mcap", "r"])
def test_a_plain_name_lies_in_the_folder(tmp_path: Path, wanted: str) -> None:
    assert confined(tmp_path, wanted) == tmp_path / "r.mcap"
    assert confined(tmp_path, str(tmp_path / "r.mcap")) == tmp_path / "r.mcap"


@pytest.mark.parametrize("wanted", ["", "..", "/", "a/b", "../x", "/etc/x.mcap", ".x", "a\nb"])
def test_anything_else_does_not(tmp_path: Path, wanted: str) -> None:
    with pytest.raises(RecordingError, match="give a plain name"):
        confined(tmp_path, wanted)


def test_a_link_is_not_written_through(tmp_path: Path) -> None:
    target = tmp_path / "precious"
    target.write_text("keep")
    link = confined(tmp_path, "link.mcap")
    link.symlink_to(target)
    with pytest.raises(RecordingError, match="exists already"):
        RunRecorder(link, RunConfiguration("robot", "job"))
    assert target.read_text() == "keep"


def test_a_length_beyond_all_measure_is_damage(recording: Path) -> None:
    """Found by fuzzing: the number of bytes named inside a chunk did not fit an index."""
    body = bytearray(chunk("", b"", 0)[9:])
    body[-8:] = b"\xff" * 8
    with recording.open("ab") as file:
        file.write(b"\x06" + len(body).to_bytes(8, "little") + body)
    assert any("damaged" in line for line in read_run(recording).damage)
