"""A recorded run as arrays: messages of one channel gathered into columns, as its row of the table
of channels says. Times are run time in ns, counts signed microsteps, lengths metres.
"""

from __future__ import annotations

import json
import math
from array import array
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.channels import Channel
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.format.messages import Int8Array

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
Int64Array = np.ndarray[Any, np.dtype[np.int64]]
_WRONG = (ValueError, KeyError, TypeError, OverflowError, AttributeError, RecursionError)
"""What messages that are not as they should be make `json` and arrays raise."""


class Columns:
    """Grows chunk by chunk; numbers cost eight bytes each, whatever JSON they came from."""

    def __init__(self, channel: Channel):
        self._channel = channel
        self._integers = {f.name: array("q") for f in channel.fields if f.kind == "integer"}
        self._numbers = {f.name: array("d") for f in channel.fields if f.kind == "number"}
        self._texts: dict[str, list[str]] = {
            f.name: [] for f in channel.fields if f.kind == "string"
        }

    def add(self, payloads: list[bytes]) -> None:
        """Append messages. Raises RecordingError when one is not what the table says."""
        try:
            messages = json.loads(b"[" + b",".join(payloads) + b"]")
            for name, integers in self._integers.items():
                integers.extend([message[name] for message in messages])
            for name, numbers in self._numbers.items():
                numbers.extend([message.get(name, math.nan) for message in messages])
            for name, texts in self._texts.items():
                texts.extend([str(message[name]) for message in messages])
        except _WRONG as error:
            raise RecordingError(
                f"a message of {self._channel.topic} is not what its schema says ({error!r})"
            ) from error

    def integers(self, name: str) -> Int64Array:
        """A column of whole numbers; shape (n,)."""
        return np.array(self._integers[name], dtype=np.int64)

    def numbers(self, *names: str) -> FloatArray:
        """One column, shape (n,), or several side by side, shape (n, len(names)); NaN = absent."""
        columns = [np.array(self._numbers[name], dtype=np.float64) for name in names]
        return columns[0] if len(columns) == 1 else np.stack(columns, axis=1)

    def texts(self, name: str) -> list[str]:
        """A column of texts."""
        return self._texts[name]

    def counts(self) -> Int64Array:
        """The three step counts; shape (n, 3)."""
        return np.stack([self.integers(f"steps_{motor}") for motor in (1, 2, 3)], axis=1)

    def rows(self) -> list[dict[str, Any]]:
        """The messages again, one dictionary each."""
        columns: dict[str, Any] = {**self._integers, **self._numbers, **self._texts}
        lists = [list(column) for column in columns.values()]
        return [dict(zip(columns, row, strict=True)) for row in zip(*lists, strict=True)]


BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
TextArray = np.ndarray[Any, np.dtype[np.str_]]


@dataclass(frozen=True, slots=True)
class Targets:
    """Points asked for. t_ns, index: (n,). position_m: (n, 3). steps: (n, 3)."""

    t_ns: Int64Array
    index: Int64Array
    position_m: FloatArray
    steps: Int64Array


@dataclass(frozen=True, slots=True)
class Commanded:
    """Counts commanded. t_ns: (n,). steps: (n, 3)."""

    t_ns: Int64Array
    steps: Int64Array


@dataclass(frozen=True, slots=True)
class Edges:
    """What really went out, edge by edge.

    t_ns: (n,). steps: (n, 3), each -1, 0 or +1; a row of zeros marks counters that were set.
    counts: (n, 3), the count from that edge on.
    """

    t_ns: Int64Array
    steps: Int8Array
    counts: Int64Array

    def counts_at(self, t_ns: Int64Array) -> Int64Array:
        """Counts sent up to and including each time; shape (len(t_ns), 3).

        Before the first entry the counts are those before it.
        """
        if not len(self.t_ns):
            return np.zeros((len(t_ns), 3), dtype=np.int64)
        before = self.counts[0] - self.steps[0]
        known = np.vstack([before[None, :], self.counts])
        return known[np.searchsorted(self.t_ns, t_ns, side="right")]


@dataclass(frozen=True, slots=True)
class Readings:
    """Samples of one sensor; all arrays have shape (n,)."""

    axis: str
    t_ns: Int64Array
    distance_m: FloatArray
    status: Int64Array
    raw_status: Int64Array
    signal_mcps: FloatArray
    ambient_mcps: FloatArray
    sigma_m: FloatArray
    stream_count: Int64Array
    gate: TextArray

    @property
    def good(self) -> BoolArray:
        """Which samples passed every gate."""
        return np.asarray(self.gate == "good", dtype=np.bool_)

    @property
    def stale(self) -> BoolArray:
        """Which samples repeat the one before: same stream count, nothing new measured."""
        return np.asarray(np.diff(self.stream_count, prepend=-1) == 0, dtype=np.bool_)

    def where(self, mask: BoolArray) -> Readings:
        """The samples for which `mask`, shape (n,), is true."""
        kept = {item.name: getattr(self, item.name) for item in fields(self) if item.name != "axis"}
        return Readings(self.axis, **{name: values[mask] for name, values in kept.items()})


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened."""

    t_ns: int
    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class Truth:
    """The simulated robot. t_ns: (n,). position_m: (n, 3). angles_rad: (n, 3)."""

    t_ns: Int64Array
    position_m: FloatArray
    angles_rad: FloatArray


@dataclass(frozen=True, slots=True)
class Servo:
    """Means over stretches of a servo's loop; empty on a stepper robot.

    t_ns: (n,). reference_rad, angle_rad, current_a, disturbance_a: (n, 3).
    """

    t_ns: Int64Array
    reference_rad: FloatArray
    angle_rad: FloatArray
    current_a: FloatArray
    disturbance_a: FloatArray


@dataclass(frozen=True, slots=True)
class Settings:
    """Step periods in force from each time on (NaN: every motor its own). Arrays (n,)."""

    t_ns: Int64Array
    t_pwm_s: FloatArray

    def t_pwm_at(self, t_ns: Int64Array) -> FloatArray:
        """Step period in force at each time [s]; NaN before the first."""
        known = np.concatenate([[np.nan], self.t_pwm_s])
        return known[np.searchsorted(self.t_ns, t_ns, side="right")]


@dataclass(frozen=True, slots=True)
class Paces:
    """Changes of pace along the path: from each time on from `rate` to `goal` within `ramp_s`.

    Parts of the planned pace: 1 as planned, 0 at rest. Arrays (n,).
    """

    t_ns: Int64Array
    rate: FloatArray
    goal: FloatArray
    ramp_s: FloatArray


@dataclass(frozen=True, slots=True)
class Run:
    """Everything one recording holds.

    `complete` is false when the file has no end (killed, full disk); `damage` says in words
    what could not be read.
    """

    path: Path
    configuration: RunConfiguration
    complete: bool
    damage: tuple[str, ...]
    targets: Targets
    commanded: Commanded
    edges: Edges
    readings: dict[str, Readings]
    events: tuple[Event, ...]
    truth: Truth
    servo: Servo
    settings: Settings
    paces: Paces
    share: float = 1.0
    """How much of the file was read; less than 1 where stretches of a long one were asked for."""

    @property
    def end_ns(self) -> int:
        """Run time of the last thing recorded."""
        arrays = [self.targets.t_ns, self.commanded.t_ns, self.edges.t_ns, self.truth.t_ns]
        arrays += [samples.t_ns for samples in self.readings.values()]
        ends = [int(array.max()) for array in arrays if len(array)]
        return max([*ends, *(event.t_ns for event in self.events)], default=0)
