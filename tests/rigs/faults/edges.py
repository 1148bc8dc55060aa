"""What the simulated drives saw: every edge with its time, read without disturbing them."""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.drivers.fakes.lines import BENCH_BYTES, ROWS, BenchMemory

Int64Array = np.ndarray[Any, np.dtype[np.int64]]
_ROW_WORDS = 4
_HEADER_WORDS = BENCH_BYTES // 8 - _ROW_WORDS * ROWS


def edge_times_ns(memory: BenchMemory) -> Int64Array:
    """Times [ns] of the edges still remembered (65536), rising; shape (n,)."""
    words = np.frombuffer(bytes(memory.buffer[:BENCH_BYTES]), dtype=np.int64)
    times_ns = words[_HEADER_WORDS::_ROW_WORDS]
    return np.sort(times_ns[times_ns > 0])


def after(times_ns: Int64Array, start_ns: int) -> Int64Array:
    """Those not before `start_ns`."""
    return times_ns[np.searchsorted(times_ns, start_ns) :]
