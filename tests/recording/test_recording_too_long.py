"""Of a recording too long to be read whole: stretches spread over all of it, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.scan import STRETCHES, Scan

ROUNDS = 1500


@pytest.fixture
def path(recorded: Callable[[int], Path]) -> Path:
    return recorded(ROUNDS)


def size_of(path: Path) -> int:
    """Bytes of all messages."""
    return sum(len(m) for part in Scan(path).chunks() for ms in part.values() for m in ms)


def test_what_is_read_of_it_is_as_it_stands_and_spread_over_all_of_it(path: Path) -> None:
    whole, part = read_run(path), read_run(path, most_bytes=size_of(path) // 2)
    assert (whole.share, whole.complete) == (1.0, True)
    assert 0.2 < part.share < 0.7
    assert part.complete
    for axis in "xyz":
        all_ns, some_ns = whole.readings[axis].t_ns, part.readings[axis].t_ns
        at = np.searchsorted(all_ns, some_ns)
        np.testing.assert_array_equal(all_ns[at], some_ns)
        np.testing.assert_array_equal(
            whole.readings[axis].distance_m[at], part.readings[axis].distance_m
        )
        assert len(some_ns) == pytest.approx(part.share * len(all_ns), rel=0.2)
        parts = np.unique(at * (STRETCHES // 2) // len(all_ns))
        assert len(parts) == STRETCHES // 2


def test_leaving_something_out_is_no_damage(path: Path) -> None:
    scan = Scan(path, most_bytes=size_of(path) // 2)
    assert list(scan.chunks())
    assert scan.damage == []
    assert scan.complete


def test_one_that_fits_is_read_whole(path: Path) -> None:
    assert read_run(path, most_bytes=10 * size_of(path)).share == 1.0
