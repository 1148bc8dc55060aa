"""What happened, as the flat dictionaries that become JSON messages.

A value that does not exist (NaN, None) is left out: JSON has no NaN, and viewers want plain
types. Numbers are rounded to 1e-9 of their unit, which no sensor of this robot comes near.

Step edges take five bytes an edge before compression, and are decoded exactly.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

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


def edges_from_message(message: dict[str, Any]) -> EdgeBlock:
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


Steps = Sequence[int] | Int64Array
Three = Sequence[float] | np.ndarray[Any, np.dtype[np.float64]]
Message = dict[str, Any]
_DECIMALS = 9


class _Named(Protocol):
    @property
    def value(self) -> Any: ...


class ReadingLike(Protocol):
    """What is recorded of a reading; `deltactl.drivers.ranging.contract.Reading` has it."""

    @property
    def axis(self) -> str: ...
    @property
    def t_ns(self) -> int: ...
    @property
    def distance_m(self) -> float: ...
    @property
    def status(self) -> int: ...
    @property
    def raw_status(self) -> int: ...
    @property
    def signal_mcps(self) -> float: ...
    @property
    def ambient_mcps(self) -> float: ...
    @property
    def sigma_m(self) -> float: ...
    @property
    def stream_count(self) -> int: ...
    @property
    def gate(self) -> _Named: ...


class ServoLike(Protocol):
    """What is recorded of a servo's loop; `firmware_py.servo.loop.ServoSample` has it."""

    @property
    def t_ns(self) -> int: ...
    @property
    def reference_rad(self) -> Sequence[float]: ...
    @property
    def angle_rad(self) -> Sequence[float]: ...
    @property
    def current_a(self) -> Sequence[float]: ...
    @property
    def disturbance_a(self) -> Sequence[float]: ...


def target(t_ns: int, index: int, position_m: Three, steps: Steps) -> Message:
    """Fields of `/target`."""
    return {"t_ns": t_ns, "index": int(index)} | _position(position_m) | counts(steps)


def counts(steps: Steps) -> Message:
    """Three signed counts."""
    first, second, third = steps
    return {"steps_1": int(first), "steps_2": int(second), "steps_3": int(third)}


def reading(t_ns: int, sample: ReadingLike) -> Message:
    """Fields of `/reading/<axis>`."""
    numbers = {
        "distance_m": sample.distance_m,
        "signal_mcps": sample.signal_mcps,
        "ambient_mcps": sample.ambient_mcps,
        "sigma_m": sample.sigma_m,
    }
    return {
        "t_ns": t_ns,
        "axis": sample.axis,
        "status": int(sample.status),
        "raw_status": int(sample.raw_status),
        "stream_count": int(sample.stream_count),
        "gate": str(sample.gate.value),
    } | _numbers(numbers)


def truth(t_ns: int, position_m: Three, angles_rad: Three) -> Message:
    """Fields of `/truth`."""
    first, second, third = angles_rad
    angles = {"theta_1_rad": first, "theta_2_rad": second, "theta_3_rad": third}
    return {"t_ns": t_ns} | _position(position_m) | _numbers(angles)


OF_A_JOINT = (("reference", "rad"), ("theta", "rad"), ("current", "a"), ("disturbance", "a"))
"""Stems and units of what a servo drive tells of each joint."""
_SERVO = tuple(f"{stem}_{joint}_{unit}" for stem, unit in OF_A_JOINT for joint in (1, 2, 3))


def servo(t_ns: int, sample: ServoLike) -> Message:
    """Fields of `/servo`."""
    values = (*sample.reference_rad, *sample.angle_rad, *sample.current_a, *sample.disturbance_a)
    return {"t_ns": t_ns} | _numbers(dict(zip(_SERVO, values, strict=True)))


def pace(t_ns: int, rate: float, goal: float, ramp_s: float) -> Message:
    """Fields of `/pace`."""
    return {"t_ns": t_ns, "rate": float(rate), "goal": float(goal), "ramp_s": float(ramp_s)}


def settings(t_ns: int, t_pwm_s: float | None) -> Message:
    """Fields of `/settings`."""
    return {"t_ns": t_ns} | _numbers({"t_pwm_s": t_pwm_s})


def _position(position_m: Three) -> Message:
    x_m, y_m, z_m = position_m
    return _numbers({"x_m": x_m, "y_m": y_m, "z_m": z_m})


def _numbers(values: Mapping[str, float | None]) -> Message:
    return {
        name: round(float(value), _DECIMALS)
        for name, value in values.items()
        if value is not None and math.isfinite(value)
    }
