"""Step edges in compact form: five bytes an edge before compression, decoded exactly."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.foundation.errors import RecordingError

MOTORS = 3
MAXIMUM_DELTA_NS = 2**32 - 1
Int64Array = np.ndarray[Any, np.dtype[np.int64]]
Int8Array = np.ndarray[Any, np.dtype[np.int8]]
_WEIGHTS = np.array([1, 2, 4], dtype=np.uint8)


@dataclass(frozen=True, slots=True)
class EdgeBlock:
    """Edges in a row, and the counts before the first of them.

    due_ns: shape (n,), run time. steps: shape (n, 3), each -1, 0 or +1. base: shape (3,).
    """

    due_ns: Int64Array
    steps: Int8Array
    base: Int64Array
    start_ns: int

    def as_message(self) -> dict[str, int | str]:
        """The fields of an `/edges` message."""
        deltas = np.diff(self.due_ns, prepend=self.start_ns).astype("<u4")
        bits = (self.steps != 0) @ _WEIGHTS | ((self.steps < 0) @ _WEIGHTS) << 3
        return {
            "t_ns": self.start_ns,
            "count": len(self.due_ns),
            "steps_1": int(self.base[0]),
            "steps_2": int(self.base[1]),
            "steps_3": int(self.base[2]),
            "delta_ns": base64.b64encode(deltas.tobytes()).decode(),
            "bits": base64.b64encode(bits.astype(np.uint8).tobytes()).decode(),
        }


def from_message(message: dict[str, Any]) -> EdgeBlock:
    """Undo `EdgeBlock.as_message`. Raises RecordingError when the parts do not fit together."""
    try:
        deltas = np.frombuffer(base64.b64decode(message["delta_ns"]), dtype="<u4")
        bits = np.frombuffer(base64.b64decode(message["bits"]), dtype=np.uint8)
    except ValueError as error:
        raise RecordingError(
            f"edges at {message['t_ns']} ns: delta_ns or bits is not base64 of whole numbers"
            f" ({error})"
        ) from None
    if not len(deltas) == len(bits) == message["count"]:
        raise RecordingError(
            f"edges at {message['t_ns']} ns: {len(deltas)} times and {len(bits)} steps "
            f"for {message['count']} edges"
        )
    stepped = (bits[:, None] & _WEIGHTS) != 0
    backwards = (bits[:, None] & (_WEIGHTS << 3)) != 0
    start_ns = int(message["t_ns"])
    return EdgeBlock(
        due_ns=start_ns + np.cumsum(deltas, dtype=np.int64),
        steps=np.where(backwards, -1, 1).astype(np.int8) * stepped.astype(np.int8),
        base=np.array([message[f"steps_{motor}"] for motor in (1, 2, 3)], dtype=np.int64),
        start_ns=start_ns,
    )


def blocks(due_ns: Int64Array, steps: Int8Array, base: Int64Array) -> Iterator[EdgeBlock]:
    """Cut edges into blocks at pauses too long for 32 bits of nanoseconds (4.29 s).

    A time that goes back (a clock that was set) starts a new block too, so nothing is lost.
    """
    if not len(due_ns):
        return
    deltas = np.diff(due_ns)
    cuts = np.flatnonzero((deltas > MAXIMUM_DELTA_NS) | (deltas < 0)) + 1
    counts = base.astype(np.int64).copy()
    for part_ns, part in zip(np.split(due_ns, cuts), np.split(steps, cuts), strict=True):
        yield EdgeBlock(part_ns, part, counts.copy(), int(part_ns[0]))
        counts += part.sum(axis=0, dtype=np.int64)


def counts_set(t_ns: int, counts: Int64Array) -> EdgeBlock:
    """An empty block: the counters were set, nothing moved."""
    nothing = np.zeros(0, dtype=np.int64)
    return EdgeBlock(nothing, np.zeros((0, MOTORS), dtype=np.int8), counts.copy(), t_ns)
