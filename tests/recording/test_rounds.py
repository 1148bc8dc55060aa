"""From a run to rows: readings in rounds, counts as sent, nothing used twice."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.flat import FlatRecording
from deltactl.recording.tables.flat_files import read_flat, write_flat
from deltactl.recording.tables.rounds import flatten
from deltactl.recording.writing.writer import RunRecorder

MS = 1_000_000

Sampled = list[tuple[str, int]]


@pytest.fixture
def flat_of(
    tmp_path: Path, sample: Any, configuration: RunConfiguration
) -> Callable[[Sampled], FlatRecording]:
    """Records samples (axis, time in ns), distance = time in seconds, and flattens."""

    def make(samples: Sampled) -> FlatRecording:
        path = tmp_path / "rounds.mcap"
        with RunRecorder(path, configuration, start_ns=0) as recorder:
            for number, (axis, t_ns) in enumerate(samples):
                recorder.reading(sample(axis, t_ns, t_ns * 1e-9, stream_count=number))
        return flatten(read_run(path))

    return make


def staggered(rounds: range, offs_ms: dict[str, float], jitter_ms: float = 0.0) -> Sampled:
    random = np.random.default_rng(3)
    found = [
        (axis, round((number * 20 + off + random.uniform(-jitter_ms, jitter_ms)) * MS))
        for number in rounds
        for axis, off in offs_ms.items()
    ]
    return sorted(found, key=lambda one: one[1])


@pytest.mark.parametrize(
    "offs_ms",
    [
        {"x": 0, "y": 0, "z": 0},
        {"x": 0, "y": 1, "z": 2},
        {"x": 0, "y": 6.7, "z": 13.3},
        {"x": 0, "y": 10, "z": 3},
        {"x": 13, "y": 5, "z": 9},
    ],
)
def test_one_row_a_round_whatever_the_stagger(
    flat_of: Callable[[Sampled], FlatRecording], offs_ms: dict[str, float]
) -> None:
    flat = flat_of(staggered(range(50), offs_ms, jitter_ms=0.4))
    assert 50 <= len(flat) <= 51
    ranges_m = flat.axes("range")
    assert ranges_m is not None
    whole = ~np.isnan(ranges_m).any(axis=1)
    assert whole.sum() >= 49
    assert np.count_nonzero(~np.isnan(ranges_m)) == 150
    np.testing.assert_allclose(np.nanmean(ranges_m, axis=1), flat.t_s, atol=1e-9)
    assert np.ptp(ranges_m[whole], axis=1).max() <= 0.0145
    for axis in "xyz":
        np.testing.assert_allclose(flat.extra[f"t_{axis}"], flat.columns[f"range_{axis}"])


def test_a_silent_sensor_leaves_empty_cells(
    flat_of: Callable[[Sampled], FlatRecording],
) -> None:
    samples = [
        one
        for one in staggered(range(40), {"x": 0, "y": 2, "z": 4})
        if not (one[0] == "y" and 200 * MS < one[1] < 400 * MS)
    ]
    flat = flat_of(samples)
    assert len(flat) == 40
    assert np.flatnonzero(np.isnan(flat.columns["range_y"])).tolist() == list(range(10, 20))
    assert np.isnan(flat.columns["status_y"][10:20]).all()
    assert not np.isnan(flat.columns["range_x"]).any()


def test_rounds_go_on_where_the_busiest_sensor_is_silent(
    flat_of: Callable[[Sampled], FlatRecording],
) -> None:
    samples = staggered(range(60), {"x": 0, "y": 2, "z": 4})
    samples = [one for one in samples if one[0] != "x" or not 300 * MS < one[1] < 500 * MS]
    samples = [one for one in samples if one[0] != "y" or one[1] > 500 * MS]
    samples = [one for one in samples if one[0] != "z" or one[1] < 800 * MS]
    flat = flat_of(samples)
    assert len(flat) == 60
    counts = {axis: np.count_nonzero(~np.isnan(flat.columns[f"range_{axis}"])) for axis in "xyz"}
    assert counts == {axis: sum(one[0] == axis for one in samples) for axis in "xyz"}


def test_a_sensor_that_repeats_itself_is_empty(
    tmp_path: Path, sample: Any, configuration: RunConfiguration
) -> None:
    path = tmp_path / "stale.mcap"
    with RunRecorder(path, configuration, start_ns=0) as recorder:
        for number in range(10):
            for axis in "xyz":
                count = 4 if axis == "z" and 4 <= number <= 6 else number
                recorder.reading(sample(axis, number * 20 * MS, 0.5, stream_count=count))
    empty = np.isnan(flatten(read_run(path)).columns["range_z"])
    assert np.flatnonzero(empty).tolist() == [5, 6]


def test_a_sample_is_used_once(flat_of: Callable[[Sampled], FlatRecording]) -> None:
    """A sensor at half the rate fills every other row, not all of them."""
    samples = staggered(range(40), {"x": 0, "y": 1})
    samples += staggered(range(0, 40, 2), {"z": 2})
    flat = flat_of(sorted(samples, key=lambda one: one[1]))
    assert np.isnan(flat.columns["range_z"]).tolist() == [False, True] * 20


def test_counts_are_those_sent_by_then(recorded: Callable[[int], Path]) -> None:
    flat = flatten(read_run(recorded(30)), with_truth=True)
    # Samples lie 0, 2 and 4 ms after the round's start, edges every 2 ms from it on.
    np.testing.assert_allclose(flat.t_s, np.arange(30) * 0.02 + 0.002, atol=1e-9)
    np.testing.assert_array_equal(flat.columns["steps_1"], np.arange(30) * 10 + 2)
    np.testing.assert_array_equal(flat.columns["steps_2"], -flat.columns["steps_1"])
    np.testing.assert_array_equal(flat.columns["t_pwm"], np.full(30, 0.006))
    middle = flat.extra["truth_y_m"][:-1]
    np.testing.assert_allclose(middle, (np.arange(29) + 0.1) * 1e-4, atol=1e-9)
    assert np.isnan(flat.extra["truth_y_m"][-1])


def test_a_run_is_a_flat_recording_too(recorded: Callable[[int], Path], tmp_path: Path) -> None:
    path = recorded(30)
    direct = read_flat(path)
    write_flat(direct, tmp_path / "out.csv.gz")
    back = read_flat(tmp_path / "out.csv.gz")
    np.testing.assert_array_equal(back.t_s, direct.t_s)
    for name, values in direct.columns.items():
        np.testing.assert_array_equal(back.columns[name], values)


def test_a_run_without_readings(tmp_path: Path, configuration: RunConfiguration) -> None:
    path = tmp_path / "none.mcap"
    RunRecorder(path, configuration).close()
    with pytest.raises(RecordingError, match="holds no readings"):
        flatten(read_run(path))


def test_a_single_reading_is_one_row(flat_of: Callable[[Sampled], FlatRecording]) -> None:
    flat = flat_of([("y", 7 * MS)])
    assert flat.t_s.tolist() == [0.007]
    assert flat.columns["range_y"].tolist() == [0.007]


def test_truth_of_a_real_robot_is_refused(
    tmp_path: Path, sample: Any, configuration: RunConfiguration
) -> None:
    path = tmp_path / "real.mcap"
    with RunRecorder(path, configuration, start_ns=0) as recorder:
        recorder.reading(sample("x", 0))
    with pytest.raises(RecordingError, match="holds no simulated truth"):
        flatten(read_run(path), with_truth=True)
