"""The step-output contract: ticks with deadlines go in, edges come out, every edge is counted."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

MOTORS = 3
Int64Array = np.ndarray[Any, np.dtype[np.int64]]
Int8Array = np.ndarray[Any, np.dtype[np.int8]]
BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
Counts = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Ticks:
    """A run of instants at which motors step.

    due_ns: shape (n,), strictly increasing, on the output's clock.
    steps: shape (n, 3), each -1, 0 or +1.
    """

    due_ns: Int64Array
    steps: Int8Array

    def __len__(self) -> int:
        return len(self.due_ns)

    def part(self, rows: slice | BoolArray) -> Ticks:
        """Some of the ticks."""
        return Ticks(self.due_ns[rows], self.steps[rows])

    @staticmethod
    def joined(parts: Sequence[Ticks]) -> Ticks:
        """Ticks of several runs, one after another."""
        if len(parts) == 1:
            return parts[0]
        due_ns = np.concatenate([NO_TICKS.due_ns, *(part.due_ns for part in parts)])
        return Ticks(due_ns, np.concatenate([NO_TICKS.steps, *(part.steps for part in parts)]))


NO_TICKS = Ticks(np.empty(0, dtype=np.int64), np.empty((0, MOTORS), dtype=np.int8))


class OutputState(enum.Enum):
    """What a step output is doing. STOPPED is latched until `acknowledge`."""

    DISABLED = "disabled"
    READY = "ready"
    MOVING = "moving"
    STOPPED = "stopped"


@dataclass(frozen=True, slots=True)
class OutputStatus:
    """A snapshot of a step output; `counts` are edges really sent, signed by direction."""

    state: OutputState
    counts: Counts
    queued: int
    slip_ns: int
    """How far the schedule was pushed back by late pulses so far."""
    reason: str = ""
    """Why the output stopped: 'e-stop', 'alarm motor2', 'no heartbeat', or the reason of `stop`."""
    energised: bool = False
    """Whether the drives hold the arms; a stop or its acknowledgement does not release them."""
    lost: bool = False
    """Whether the player is gone for good: nobody watches inputs and drives any more."""
    switched: int = 0
    """Pin levels of the outputs that jobs switch, see drivers/steps/lines.py."""


class StepOutput(Protocol):
    """Plays ticks at their deadlines, never bunched, and owns the exact step counters.

    A late tick pushes the rest of the schedule back. `stop` drops the queue within one
    tick and latches; nothing moves until `acknowledge` and `enable`. A stop keeps the drives
    energised (the arms do not drop); only `disable` releases them. After a PulseFault the
    output is of no more use: close it, build another, and home.
    """

    @property
    def minimum_period_ns(self) -> int:
        """Ticks closer than this are refused by `push`."""

    def enable(self) -> None:
        """Energise the drives, and wait until they listen (0.2 s) if they were not energised.

        Raises NotReady while stopped, DriveAlarm or EmergencyStop when tripped, PulseFault.
        """

    def disable(self) -> None:
        """Drop the queue and release the drives (the arms may drop); allowed while stopped."""

    def push(self, ticks: Ticks) -> None:
        """Queue ticks; counts as a beat. The first should be due 10 ms or more ahead.

        Raises PulseFault when there is no room, NotReady unless enabled, LimitExceeded when
        two ticks are closer than `minimum_period_ns`, ValueError when they are no ticks.
        """

    def room(self) -> int:
        """How many more ticks fit into the queue."""

    def status(self) -> OutputStatus:
        """State, counters, queue length."""

    def take_sent(self) -> Ticks:
        """Ticks really sent since the last call, with the times of their edges."""

    def set_counts(self, counts: Counts) -> None:
        """Say where the motors are (homing). Raises NotReady while moving."""

    def switch(self, levels: int, mask: int) -> None:
        """Put switched outputs to pin levels, bits as in drivers/steps/lines.py.

        Every stop, `disable` and `close` put them to their safe levels, and so does the end of
        the controller. Raises NotReady while stopped or not enabled, PulseFault.
        """

    def stop(self, reason: str) -> None:
        """Stop at once and latch."""

    def acknowledge(self) -> None:
        """Release the latch. Raises EmergencyStop or DriveAlarm while the cause persists."""

    def beat(self) -> None:
        """Say that the controller is alive; without it motion stops after `heartbeat_s`."""

    def close(self) -> None:
        """Stop, leave the outputs safe, and give the pins back."""
