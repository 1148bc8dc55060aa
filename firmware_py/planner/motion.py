"""What the planner hands on: ticks, and which targets are reached when."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, Int64Array, Ticks
from deltactl.firmware_py.paths.path import BoolArray
from deltactl.models.robot import FloatArray

if TYPE_CHECKING:
    from deltactl.firmware_py.planner.step_gate import StepGate


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
            index=self.index[rows],
            number=self.number[rows],
            repeat=self.repeat[rows],
            t_ns=self.t_ns[rows],
            position_m=self.position_m[rows],
            angles_rad=self.angles_rad[rows],
            counts=self.counts[rows],
            left=self.left[rows],
        )


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
        ticks = self.ticks
        before = Chunk(
            ticks=Ticks(ticks.due_ns[:tick], ticks.steps[:tick]),
            reached=self.reached.part(slice(None, target)),
            until_ns=min(at_ns, self.until_ns),
        )
        after = Chunk(
            ticks=Ticks(ticks.due_ns[tick:], ticks.steps[tick:]),
            reached=self.reached.part(slice(target, None)),
            until_ns=self.until_ns,
        )
        return before, after

    def at(self, tick_ns: Int64Array, target_ns: Int64Array, until_ns: int) -> Chunk:
        """The same with other times."""
        return Chunk(
            ticks=Ticks(tick_ns, self.ticks.steps),
            reached=replace(self.reached, t_ns=target_ns),
            until_ns=until_ns,
        )


NOTHING_REACHED = Reached(
    index=np.empty(0, dtype=np.int64),
    number=np.empty(0, dtype=np.int64),
    repeat=np.empty(0, dtype=np.int64),
    t_ns=np.empty(0, dtype=np.int64),
    position_m=np.empty((0, MOTORS)),
    angles_rad=np.empty((0, MOTORS)),
    counts=np.empty((0, MOTORS), dtype=np.int64),
    left=np.empty(0, dtype=np.bool_),
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
    """What a `StepGate` for these steps must be told: merge window and gap of one motor."""

    def play(self, first: int, last: int, start_ns: int, gate: StepGate) -> Iterator[Ticks]:
        """Ticks from target `first` to target `last`, the lap beginning at `start_ns`."""
