"""Step edges survive their compact form exactly, whatever their times and pauses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.format.messages import blocks, counts_set, edges_from_message
from deltactl.recording.reading.reader import read_run
from deltactl.recording.writing.writer import RunRecorder

DELTAS_NS = st.lists(
    st.one_of(st.integers(1, 60_000), st.integers(2**32 - 3, 2**32 + 3), st.just(10**12)),
    min_size=1,
    max_size=60,
)


def some_steps(n: int, seed: int) -> np.ndarray[Any, np.dtype[np.int8]]:
    return np.random.default_rng(seed).integers(-1, 2, (n, 3)).astype(np.int8)


@given(deltas_ns=DELTAS_NS, start_ns=st.integers(-(10**9), 10**15), seed=st.integers(0, 99))
def test_blocks_decode_exactly(deltas_ns: list[int], start_ns: int, seed: int) -> None:
    due_ns = start_ns + np.cumsum(deltas_ns)
    steps = some_steps(len(due_ns), seed)
    base = np.array([5, -7, 10**9])
    found = [
        edges_from_message(json.loads(json.dumps(block.as_message())))
        for block in blocks(due_ns, steps, base)
    ]
    np.testing.assert_array_equal(np.concatenate([block.due_ns for block in found]), due_ns)
    np.testing.assert_array_equal(np.concatenate([block.steps for block in found]), steps)
    counts = base
    for block in found:
        np.testing.assert_array_equal(block.base, counts)
        counts = counts + block.steps.sum(axis=0, dtype=np.int64)


def test_a_clock_that_goes_back_loses_no_edge() -> None:
    due_ns = np.array([10, 20, 5, 6])
    found = [
        edges_from_message(block.as_message())
        for block in blocks(due_ns, some_steps(4, 1), due_ns[:3])
    ]
    assert np.concatenate([block.due_ns for block in found]).tolist() == [10, 20, 5, 6]


def test_parts_that_do_not_fit_are_refused() -> None:
    message = next(iter(blocks(np.array([1, 2]), some_steps(2, 1), np.zeros(3)))).as_message()
    with pytest.raises(RecordingError, match="2 times and 2 steps for 3 edges"):
        edges_from_message(message | {"count": 3})


def test_setting_the_counters_is_a_block_without_edges() -> None:
    block = edges_from_message(counts_set(77, np.array([1, 2, 3])).as_message())
    assert len(block.due_ns) == 0
    assert block.base.tolist() == [1, 2, 3]


def test_counts_at_any_time(tmp_path: Path, configuration: RunConfiguration) -> None:
    """Pushed in pieces, with the counters set in between: the staircase is exact."""
    path = tmp_path / "edges.mcap"
    with RunRecorder(path, configuration, start_ns=100, counts=(10, 20, 30)) as recorder:
        recorder.edges(np.array([200, 300]), np.array([[1, 0, -1], [1, 0, 0]], dtype=np.int8))
        recorder.edges(np.array([400]), np.array([[0, 1, 0]], dtype=np.int8))
        recorder.counts_set(500, (0, 0, 0))
        recorder.edges(np.array([600]), np.array([[-1, -1, -1]], dtype=np.int8))
    edges = read_run(path).edges
    at_ns = np.array([0, 99, 100, 199, 200, 299, 300, 399, 400, 499, 500, 1000])
    np.testing.assert_array_equal(
        edges.counts_at(at_ns),
        [[10, 20, 30]] * 2
        + [[11, 20, 29]] * 2
        + [[12, 20, 29]] * 2
        + [[12, 21, 29]] * 2
        + [[0, 0, 0]] * 2
        + [[-1, -1, -1]] * 2,
    )


def test_where_the_motors_stood_is_known_of_a_run_in_which_none_moved(
    tmp_path: Path, configuration: RunConfiguration
) -> None:
    path = tmp_path / "still.mcap"
    with RunRecorder(path, configuration, start_ns=100, counts=(10, 20, 30)):
        pass
    assert read_run(path).edges.counts_at(np.array([100, 200])).tolist() == [[10, 20, 30]] * 2
