"""Recordings that end badly: cut anywhere, damaged, killed, disk full, never a recording."""

from __future__ import annotations

import io
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import ChunkIndex
from mcap.writer import CompressionType, Writer

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.writing.spool import WAITING_BYTES, Spool
from deltactl.recording.writing.writer import RunRecorder

MS = 1_000_000


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A complete recording of 8 s in 16 chunks, one event every 20 ms."""
    path = tmp_path_factory.mktemp("cut") / "whole.mcap"
    with RunRecorder(path, RunConfiguration("robot", "job")) as recorder:
        for number in range(400):
            recorder.event(number * 20 * MS, "number", str(number))
    return path.read_bytes()


def whole_chunks(whole: bytes) -> list[ChunkIndex]:
    """The chunks in file order, as the official reader finds them."""
    summary = make_reader(io.BytesIO(whole)).get_summary()
    assert summary is not None
    return sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25, deadline=None
)
@given(part=st.floats(0.0, 1.0, exclude_max=True))
def test_cut_anywhere_gives_all_up_to_there(whole: bytes, tmp_path: Path, part: float) -> None:
    cut = int(part * len(whole))
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[:cut])
    chunks = whole_chunks(whole)
    ends = [chunk.chunk_start_offset + chunk.chunk_length for chunk in chunks]
    if cut < ends[0]:
        with pytest.raises(RecordingError) as caught:
            read_run(path)
        assert "\n" not in str(caught.value)
        return
    run = read_run(path)
    texts = [event.text for event in run.events]
    assert texts == [str(number) for number in range(len(texts))]
    last_ns = max(
        chunk.message_end_time for chunk, end in zip(chunks, ends, strict=True) if end <= cut
    )
    assert run.configuration.start_epoch_ns + run.events[-1].t_ns >= last_ns
    assert run.complete != bool(run.damage)


def test_cut_in_a_chunk_keeps_all_chunks_before(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    chunk = whole_chunks(whole)[9]
    path.write_bytes(whole[: chunk.chunk_start_offset + chunk.chunk_length // 2])
    run = read_run(path)
    assert len(run.events) >= 9 * 25
    assert "cut off at byte" in run.damage[0]


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25, deadline=None
)
@given(part=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_damage_never_invents_anything(whole: bytes, tmp_path: Path, part: float, bit: int) -> None:
    data = bytearray(whole)
    data[int(part * len(data))] ^= 1 << bit
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    try:
        run = read_run(path)
    except RecordingError:
        return
    assert {event.text for event in run.events} <= {str(number) for number in range(400)}


def test_a_damaged_chunk_is_left_out_and_said(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "damaged.mcap"
    chunk = whole_chunks(whole)[3]
    data = bytearray(whole)
    data[chunk.chunk_start_offset + chunk.chunk_length - 5] ^= 0xFF
    path.write_bytes(data)
    run = read_run(path)
    assert len(run.damage) == 1
    assert 350 < len(run.events) < 400


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "is empty"),
        (b"t,steps_1\n0,1\n", "is not an MCAP recording"),
        (b"\x89MCAP0\r\n", "without channels"),
        (b"\x89MCAP0\r\n" + bytes(500), "without channels"),
    ],
)
def test_garbage_is_one_clear_line(tmp_path: Path, content: bytes, says: str) -> None:
    path = tmp_path / "garbage.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=says) as caught:
        read_run(path)
    assert str(path) in str(caught.value)


@given(content=st.binary(max_size=400))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_random_bytes_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "random.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + content)
    with pytest.raises(RecordingError):
        read_run(path)


@pytest.mark.parametrize("compression", list(CompressionType))
def test_other_mcap_files_are_named_as_such(tmp_path: Path, compression: CompressionType) -> None:
    path = tmp_path / "other.mcap"
    writer = Writer(str(path), compression=compression)
    writer.start()
    schema_id = writer.register_schema("Pose", "jsonschema", b"{}")
    channel_id = writer.register_channel("/pose", "json", schema_id)
    writer.add_message(channel_id, 1, b"{}", 1)
    writer.finish()
    with pytest.raises(RecordingError, match=r"not a recording of deltactl \(it has /pose\)"):
        read_run(path)


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="cannot be read"):
        read_run(tmp_path / "none.mcap")
    with pytest.raises(RecordingError, match="cannot be read"):
        read_run(tmp_path)


@pytest.fixture
def small_disk() -> Iterator[None]:
    """The kernel refuses to let files grow past 60 kB, as a full disk would."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_full_disk_keeps_what_was_written(
    tmp_path: Path, configuration: RunConfiguration, small_disk: None
) -> None:
    said: list[str] = []
    recorder = RunRecorder(
        tmp_path / "full.mcap", configuration, wait_when_behind=True, on_failure=said.append
    )
    random = np.random.default_rng(1)
    for number in range(4000):
        recorder.event(number * 20 * MS, "number", f"{number} {random.bytes(24).hex()}")
    recorder.close()
    assert len(said) == 1
    assert said[0] == recorder.failed
    assert "recording stopped: File too large" in said[0]
    run = read_run(recorder.path)
    numbers = [int(event.text.split()[0]) for event in run.events]
    assert numbers == list(range(len(numbers)))
    assert len(numbers) > 500
    # Every message is either in the file or counted as lost, and the configuration is one too.
    assert len(numbers) + recorder.lost == 4000
    assert run.damage == () or run.damage[0].startswith("cut off")


def test_too_little_room_is_refused_and_leaves_no_file(
    tmp_path: Path, configuration: RunConfiguration
) -> None:
    path = tmp_path / "never.mcap"
    with pytest.raises(RecordingError, match="MiB free on this disk"):
        RunRecorder(path, configuration, reserve_bytes=2**62)
    assert not path.exists()


def test_a_folder_that_cannot_be_made(tmp_path: Path, configuration: RunConfiguration) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(RecordingError, match="cannot be made"):
        RunRecorder(tmp_path / "file" / "run.mcap", configuration)


def test_a_disk_too_slow_is_said_once_and_memory_stays_bounded() -> None:
    spool = Spool(lambda: None, wait_when_behind=False)  # nobody takes anything out
    piece = bytes(2**20)
    answers = [spool.add(1, number, piece) for number in range(WAITING_BYTES // 2**20 + 20)]
    assert answers.count(False) == 1
    assert spool.lost == len(answers) - 1 - answers.index(False)


def test_in_simulation_the_caller_waits_for_a_slow_disk() -> None:
    spool = Spool(lambda: None, wait_when_behind=True)
    written = []

    def slow_disk() -> None:
        while (block := spool.take(0.2)) is not None:
            written.append(block.messages())
            spool.done(block)

    thread = threading.Thread(target=slow_disk)
    pieces = WAITING_BYTES // 2**20 + 5
    threading.Timer(0.05, thread.start).start()
    for number in range(pieces):
        assert spool.add(1, number, bytes(2**20))
    assert spool.wait_written(5.0)
    thread.join()
    assert sum(written) == pieces
    assert spool.lost == 0


_VICTIM = """
import sys, time
from pathlib import Path
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.writing.writer import RunRecorder
start_ns = time.monotonic_ns()
recorder = RunRecorder(Path(sys.argv[1]), RunConfiguration("r", "j"), start_ns=start_ns)
while True:
    now_ns = time.monotonic_ns()
    recorder.event(now_ns, "tick", str(now_ns - start_ns))
    print(now_ns - start_ns, flush=True)
    time.sleep(0.01)
"""


def test_kill_leaves_all_but_the_last_second(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    command = [sys.executable, "-c", _VICTIM, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as victim:
        assert victim.stdout is not None
        victim.stdout.readline()
        time.sleep(2.2)
        victim.send_signal(signal.SIGKILL)
        told_ns = [int(line) for line in victim.stdout]
    run = read_run(path)
    assert not run.complete
    assert told_ns[-1] - run.events[-1].t_ns < 1_000_000_000
    assert run.events[-1].t_ns > 1_000_000_000
    found = {event.t_ns for event in run.events}
    assert found >= {t_ns for t_ns in told_ns if t_ns <= run.events[-1].t_ns}
