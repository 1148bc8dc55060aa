"""What is recorded comes back, exactly, and official tools can read it."""

from __future__ import annotations

import datetime
import json
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Footer, SummaryOffset
from mcap.stream_reader import StreamReader

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.channels import CHANNELS, WRITTEN
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.writing.retention import fresh_path
from deltactl.recording.writing.writer import RunRecorder

MS = 1_000_000
START_NS = 5_000_000_000
EPOCH_NS = 1_700_000_000_000_000_000


def test_everything_comes_back(recorded: Callable[[int], Path]) -> None:
    run = read_run(recorded(100))
    assert run.complete
    assert run.damage == ()
    np.testing.assert_array_equal(run.targets.t_ns, np.arange(100) * 20 * MS)
    np.testing.assert_array_equal(run.targets.index, np.arange(100))
    np.testing.assert_allclose(run.targets.position_m[:, 1], np.arange(100) * 1e-4, atol=1e-12)
    np.testing.assert_array_equal(run.targets.steps[-1], [99, -99, 198])
    np.testing.assert_array_equal(run.commanded.steps, run.targets.steps)
    np.testing.assert_array_equal(run.readings["z"].t_ns, np.arange(100) * 20 * MS + 4 * MS)
    np.testing.assert_allclose(run.readings["x"].distance_m, 0.6 + np.arange(100) * 1e-4)
    assert set(run.readings["y"].gate) == {"good"}
    np.testing.assert_array_equal(run.edges.counts[-1], [1000, -1000, 0])
    np.testing.assert_allclose(run.truth.angles_rad[3], [0.1, 0.2, 0.3])
    assert [event.kind for event in run.events] == ["path_start", "path_end"]
    assert run.settings.t_pwm_at(np.array([-1, 0, MS]))[1:] == pytest.approx([0.006, 0.006])
    assert run.end_ns == 100 * 20 * MS


def test_configuration_travels_along(
    recorded: Callable[[int], Path], configuration: RunConfiguration
) -> None:
    found = read_run(recorded(1)).configuration
    assert found.robot_text == configuration.robot_text
    assert found.settings == {"t_pwm_s": 0.006}
    assert found.simulated
    assert found.start_epoch_ns == EPOCH_NS


def test_a_newer_format_is_refused(
    tmp_path: Path, configuration: RunConfiguration, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "newer.mcap"
    with monkeypatch.context() as patch:
        patch.setattr("deltactl.recording.format.configuration.FORMAT", 2)
        RunRecorder(path, configuration).close()
    with pytest.raises(RecordingError, match=r"newer\.mcap: was written by a newer deltactl"):
        read_run(path)


def test_official_reader_finds_summary_and_messages(recorded: Callable[[int], Path]) -> None:
    with recorded(120).open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert {found.topic for found in summary.channels.values()} == {
            channel.topic for channel in WRITTEN
        }
        messages = list(reader.iter_messages())
        assert len(messages) == summary.statistics.message_count
        assert len(list(reader.iter_messages(topics="/target"))) == 120
        assert {found.name for found in reader.iter_attachments()} == {"robot.yaml", "job.yaml"}
        metadata = next(iter(reader.iter_metadata())).metadata
    assert metadata["robot"] == "zhao-2023"
    first, last = summary.statistics.message_start_time, summary.statistics.message_end_time
    assert first == EPOCH_NS
    assert last == EPOCH_NS + 120 * 20 * MS


def test_messages_are_what_their_schema_says(recorded: Callable[[int], Path]) -> None:
    kinds: dict[str, type[Any] | tuple[type[Any], ...]] = {
        "integer": int,
        "number": (int, float),
        "string": str,
    }
    seen = set()
    with recorded(60).open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            promised = json.loads(schema.data)
            fields = json.loads(message.data)
            assert set(promised["required"]) <= set(fields) <= set(promised["properties"])
            for name, value in fields.items():
                assert isinstance(value, kinds[promised["properties"][name]["type"]])
            seen.add(channel.topic)
    assert seen == {channel.topic for channel in CHANNELS} - {"/servo"}  # see tests/servo


def test_log_time_is_wall_clock_plus_run_time(recorded: Callable[[int], Path]) -> None:
    with recorded(10).open("rb") as stream:
        for _, _, message in make_reader(stream).iter_messages():
            assert message.log_time == EPOCH_NS + json.loads(message.data)["t_ns"]


def test_absent_numbers_stay_absent(recorder: RunRecorder, sample: Any) -> None:
    recorder.reading(sample("x", START_NS, distance_m=float("nan")))
    recorder.truth(START_NS, (0.1, float("inf"), 0.2), (0.0, 0.0, 0.0))
    recorder.settings(START_NS, None)
    recorder.close()
    run = read_run(recorder.path)
    assert np.isnan(run.readings["x"].distance_m).all()
    assert np.isnan(run.truth.position_m[0, 1])
    assert np.isnan(run.settings.t_pwm_s).all()


def test_many_threads_lose_nothing(recorder: RunRecorder) -> None:
    def work(name: int) -> None:
        for number in range(300):
            recorder.event(START_NS + number * MS, f"thread{name}", str(number))

    threads = [threading.Thread(target=work, args=(name,)) for name in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    recorder.close()
    events = read_run(recorder.path).events
    for name in range(4):
        texts = [event.text for event in events if event.kind == f"thread{name}"]
        assert texts == [str(number) for number in range(300)]


def test_flushed_messages_are_in_the_file_at_once(recorder: RunRecorder) -> None:
    recorder.event(START_NS, "note", "now")
    assert recorder.flush()
    run = read_run(recorder.path)
    assert [event.text for event in run.events] == ["now"]
    assert not run.complete


def test_nothing_is_overwritten(recorder: RunRecorder, configuration: RunConfiguration) -> None:
    with pytest.raises(RecordingError, match="exists already"):
        RunRecorder(recorder.path, configuration)
    recorder.close()
    assert read_run(recorder.path).complete


def test_messages_after_the_end_are_counted(recorder: RunRecorder) -> None:
    recorder.close()
    recorder.event(START_NS, "late", "too late")
    recorder.close()
    assert recorder.lost == 1
    assert read_run(recorder.path).events == ()


def test_the_index_leads_viewers_to_the_messages_of_each_channel(
    recorded: Callable[[int], Path],
) -> None:
    path = recorded(300)
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    data, found = path.read_bytes(), 0
    for chunk in summary.chunk_indexes:
        for channel, offset in chunk.message_index_offsets.items():
            assert data[offset] == Opcode.MESSAGE_INDEX
            assert int.from_bytes(data[offset + 9 : offset + 11], "little") == channel
            found += 1
    assert found >= len(summary.chunk_indexes) > 0
    assert summary.statistics is not None
    assert summary.statistics.chunk_count == len(summary.chunk_indexes)


def test_the_summary_says_where_each_group_of_it_lies(recorded: Callable[[int], Path]) -> None:
    path = recorded(100)
    with path.open("rb") as stream:
        found = list(StreamReader(stream, emit_chunks=True).records)
    groups = [one for one in found if isinstance(one, SummaryOffset)]
    footer = next(one for one in found if isinstance(one, Footer))
    at, data = footer.summary_start, path.read_bytes()
    for group in groups:
        assert group.group_start == at
        assert data[at] == group.group_opcode
        at += group.group_length
    assert at == footer.summary_offset_start


def test_recordings_begun_in_one_second_are_numbered(tmp_path: Path) -> None:
    start = datetime.datetime(2026, 3, 4, 5, 6, 7)
    names = []
    for _ in range(3):
        path = fresh_path(tmp_path, "heart", start)
        path.touch()
        names.append(path.name)
    stem = "heart-2026-03-04T05-06-07"
    assert names == [f"{stem}.mcap", f"{stem}-2.mcap", f"{stem}-3.mcap"]


def test_fresh_names_differ_and_are_plain(tmp_path: Path) -> None:
    first = fresh_path(tmp_path, "my heart/../x")
    assert first.parent == tmp_path
    first.touch()
    assert first.name.startswith("my-heart-..-x-2")
    second = fresh_path(tmp_path, "a")
    second.touch()
    assert not fresh_path(tmp_path, "a").exists()
