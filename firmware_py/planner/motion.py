"""What the planner hands on: ticks, and which targets are reached when.

Steps of three motors, each with its own time, become ticks that can be played. Two rules: a motor's
steps keep a gap (only a motor that turns round within it is held back), and steps of different
motors that fall within the merge window become one tick at the time of the first, because two
pulses a few microseconds apart cannot be sent in time to any output. With a gap of a window or more
a tick never holds two steps of one motor, and no step moves by more than a window.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, NO_TICKS, Int64Array, Ticks
from deltactl.firmware_py.paths.path import BoolArray
from deltactl.models.robot import FloatArray

LONG_AGO = -(2**62)
NEVER = 2**62


class StepGate:
    """Steps in, ticks out, a stretch of time a call; what may still change waits for the next."""

    def __init__(self) -> None:
        self._merge_ns = 0
        self._gap_ns = 0
        self._last_ns = [LONG_AGO] * MOTORS
        self._last_tick_ns = LONG_AGO
        self._clear()

    def rules(self, merge_ns: int, gap_ns: int) -> None:
        """Merge window and gap of one motor from here on (`Schedule.gate_ns`)."""
        self._merge_ns = merge_ns
        self._gap_ns = gap_ns

    @property
    def settled_ns(self) -> int:
        """No tick still to come is due at or before this time, unless a later step is."""
        return min((int(times[0]) - 1 for times in self._wait_ns if len(times)), default=NEVER)

    def ticks(
        self, due_ns: list[Int64Array], steps: list[Int64Array], until_ns: int = NEVER
    ) -> Ticks:
        """Ticks of each motor's step times (non-decreasing) and signs, motor by motor.

        Steps of later calls must not be due before `until_ns`; at the end of a motion leave
        it out, and nothing waits.
        """
        held = [
            np.concatenate([self._wait_ns[motor], self._keep_gap(motor, times)])
            for motor, times in enumerate(due_ns)
        ]
        signs = np.concatenate(
            [part for motor in range(MOTORS) for part in (self._wait_steps[motor], steps[motor])]
        )
        self._clear()
        t_ns = np.concatenate(held)
        if not len(t_ns):
            return NO_TICKS
        order = np.argsort(t_ns, kind="stable")
        t_ns, signs = t_ns[order], signs[order]
        motor = np.repeat(np.arange(MOTORS), [len(times) for times in held])[order]
        starts = _group_starts(t_ns, self._merge_ns)
        tick = np.cumsum(starts) - 1
        first_ns = t_ns[starts]
        ready = int(np.searchsorted(first_ns, until_ns - self._merge_ns, side="right"))
        count = int(np.searchsorted(tick, ready))
        self._keep(t_ns[count:], signs[count:], motor[count:])
        out = np.zeros((ready, MOTORS), dtype=np.int8)
        out[tick[:count], motor[:count]] = signs[:count]
        return Ticks(self._space_ticks(first_ns[:ready]), out)

    def _clear(self) -> None:
        self._wait_ns: list[Int64Array] = [np.empty(0, dtype=np.int64)] * MOTORS
        self._wait_steps: list[Int64Array] = [np.empty(0, dtype=np.int64)] * MOTORS

    def _keep(self, t_ns: Int64Array, signs: Int64Array, motor: Int64Array) -> None:
        """Steps of the ticks that may yet get company."""
        self._wait_ns = [t_ns[motor == its] for its in range(MOTORS)]
        self._wait_steps = [signs[motor == its] for its in range(MOTORS)]

    def _keep_gap(self, motor: int, t_ns: Int64Array) -> Int64Array:
        if not len(t_ns):
            return t_ns
        # t'[k] = max(t[k], t'[k-1] + gap), as a running maximum.
        ramp = np.arange(len(t_ns)) * self._gap_ns
        first = max(int(t_ns[0]), self._last_ns[motor] + self._gap_ns)
        slack = t_ns - ramp
        slack[0] = first
        kept: Int64Array = np.maximum.accumulate(slack) + ramp
        self._last_ns[motor] = int(kept[-1])
        return kept

    def _space_ticks(self, t_ns: Int64Array) -> Int64Array:
        """Ticks at least a window (and 1 ns) apart, also from one motion to the next."""
        if not len(t_ns):
            return t_ns
        apart = max(1, self._merge_ns)
        ramp = np.arange(len(t_ns)) * apart
        slack = t_ns - ramp
        slack[0] = max(int(slack[0]), self._last_tick_ns + apart)
        spaced: Int64Array = np.maximum.accumulate(slack) + ramp
        self._last_tick_ns = int(spaced[-1])
        return spaced


def _group_starts(t_ns: Int64Array, merge_ns: int) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which of the sorted times begin a tick: those not within the window of one that does."""
    window_ns = max(1, merge_ns)
    starts = np.ones(len(t_ns), dtype=np.bool_)
    starts[1:] = np.diff(t_ns) >= window_ns
    begin = np.flatnonzero(starts)
    end = np.append(begin[1:], len(t_ns))
    for row in np.flatnonzero(t_ns[end - 1] - t_ns[begin] >= window_ns):
        chain = slice(begin[row], end[row])
        starts[chain] = _starts_of_chain(t_ns[chain].tolist(), window_ns)
    return starts


def _starts_of_chain(t_ns: list[int], window_ns: int) -> list[bool]:
    """The same for times of which each is within the window of the one before it."""
    starts, free_ns = [], t_ns[0]
    for time_ns in t_ns:
        starts.append(time_ns >= free_ns)
        if starts[-1]:
            free_ns = time_ns + window_ns
    return starts


@dataclass(frozen=True, slots=True, eq=False)
class Reached:
    """Targets and when each is due: the last step towards it is made by then; arrays of n rows.

    left: (n,), whether that is when a target is left: one in space at which the arms rest comes
    twice, when it is reached and when the rest is over.

    index: (n,), running number in the job from 0. number: (n,), number in the path, -1 on
    the way back to its start. repeat: (n,), from 1. t_ns: (n,), from the motion's start.
    position_m, angles_rad, counts: (n, 3).
    """

    index: Int64Array
    number: Int64Array
    repeat: Int64Array
    t_ns: Int64Array
    position_m: FloatArray
    angles_rad: FloatArray
    counts: Int64Array
    left: BoolArray

    def __len__(self) -> int:
        return len(self.t_ns)

    def part(self, rows: slice) -> Reached:
        """Some of the targets."""
        return Reached(
            *(self.index[rows], self.number[rows], self.repeat[rows], self.t_ns[rows]),
            *(self.position_m[rows], self.angles_rad[rows], self.counts[rows], self.left[rows]),
        )

    @staticmethod
    def joined(parts: Sequence[Reached]) -> Reached:
        """The targets of one part or more, one after another."""
        if len(parts) == 1:
            return parts[0]
        columns = ([getattr(part, name) for part in parts] for name in Reached.__slots__)
        return Reached(*(np.concatenate(column) for column in columns))


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """A piece of a motion: everything after the chunk before it and up to `until_ns`.

    All times are from the motion's start.
    """

    ticks: Ticks
    reached: Reached
    until_ns: int

    def split(self, at_ns: int) -> tuple[Chunk, Chunk]:
        """What is due up to and including `at_ns`, and the rest."""
        tick = int(np.searchsorted(self.ticks.due_ns, at_ns, side="right"))
        target = int(np.searchsorted(self.reached.t_ns, at_ns, side="right"))
        ticks, reached = self.ticks.part(slice(tick)), self.reached.part(slice(target))
        before = Chunk(ticks, reached, min(at_ns, self.until_ns))
        ticks, reached = self.ticks.part(slice(tick, None)), self.reached.part(slice(target, None))
        return before, Chunk(ticks, reached, self.until_ns)

    def at(self, tick_ns: Int64Array, target_ns: Int64Array, until_ns: int) -> Chunk:
        """The same with other times."""
        reached = replace(self.reached, t_ns=target_ns)
        return Chunk(Ticks(tick_ns, self.ticks.steps), reached, until_ns)


_NONE, _NO_ROWS = np.empty(0, dtype=np.int64), np.empty((0, MOTORS))
NOTHING_REACHED = Reached(
    *(_NONE, _NONE, _NONE, _NONE),
    *(_NO_ROWS, _NO_ROWS, _NO_ROWS.astype(np.int64), _NONE.astype(np.bool_)),
)


class Schedule(Protocol):
    """When the steps between the targets of one lap are due. Target 0 is where the arms are."""

    reached_ns: Int64Array
    """(n,), when each target is reached, from the lap's start."""
    left_ns: Int64Array
    """(n,), when the rest at each target is over; `reached_ns` where there is none."""
    duration_ns: int
    """Until the rest at the last target is over."""
    rest_ns: int
    """How much of that the arms rest at targets."""
    peak_rate_hz: FloatArray
    """(3,), no motor's steps come faster."""
    gate_ns: tuple[int, int]
    """What a `StepGate` for these steps must know: merge window and gap of one motor."""

    def play(self, first: int, last: int, start_ns: int, gate: StepGate) -> Iterator[Ticks]:
        """Ticks from target `first` to target `last`, the lap beginning at `start_ns`."""
