"""The side of a step output that the controller sees: the same for every host of the player."""

from __future__ import annotations

import threading
import time
from typing import Any, Protocol

import numpy as np

from deltactl.drivers.steps import board as b
from deltactl.drivers.steps.contract import (
    MOTORS,
    BoolArray,
    Counts,
    Int8Array,
    Int64Array,
    OutputState,
    OutputStatus,
    Ticks,
)
from deltactl.foundation.clock import Clock, sleep_s
from deltactl.foundation.errors import (
    DeltactlError,
    DriveAlarm,
    EmergencyStop,
    LimitExceeded,
    NotReady,
    PulseFault,
)

Codes = np.ndarray[Any, np.dtype[np.uint8]]

_MOTORS = np.arange(MOTORS, dtype=np.uint8)
_STEPPING = np.array([1, 2, 4], dtype=np.uint8)
_NEGATIVE = _STEPPING << 3
_EVERY = np.arange(64)[:, np.newaxis]
_STEPS_OF = ((_EVERY >> _MOTORS & 1) * (1 - 2 * (_EVERY >> _MOTORS + 3 & 1))).astype(np.int8)
"""Steps of each of the 64 codes."""


def as_ticks(ticks: Ticks) -> tuple[Int64Array, Codes]:
    """Due times and codes, each of shape (n,). Raises ValueError when they are no ticks."""
    due_ns = np.asarray(ticks.due_ns)
    steps = np.asarray(ticks.steps)
    if due_ns.ndim != 1 or steps.shape != (len(due_ns), MOTORS):
        raise ValueError(f"ticks need shapes (n,) and (n, 3), not {due_ns.shape}, {steps.shape}")
    if due_ns.dtype.kind != "i" or steps.dtype.kind != "i":
        raise ValueError(f"ticks must be whole numbers, not {due_ns.dtype} and {steps.dtype}")
    if np.abs(steps).max(initial=0) > 1:
        raise ValueError("a tick steps each motor by -1, 0 or +1")
    codes = (steps != 0) @ _STEPPING | (steps < 0) @ _NEGATIVE
    return due_ns.astype(np.int64, copy=False), codes


def as_steps(codes: Codes) -> Int8Array:
    """Steps of shape (n, 3), each -1, 0 or +1."""
    steps: Int8Array = _STEPS_OF[codes & 0b111111]
    return steps


def stepping(codes: Codes) -> BoolArray:
    """Which codes step a motor; shape (n,)."""
    moves: BoolArray = (codes & 0b111) != 0
    return moves


ENABLE_SETTLE_S = 0.2
"""CL57T manual, sequence of control signals: ENA at least 200 ms before DIR."""
ANSWER_S = 1.0
"""A player that has not answered a request for so long is not there any more."""

_STATES = tuple(OutputState)
"""By the board's numbers for them."""
_REFUSED: dict[int, tuple[type[DeltactlError], str]] = {
    b.IS_STOPPED: (NotReady, "stopped ({why}); acknowledge the stop first"),
    b.IS_DISABLED: (NotReady, "the drives are not enabled; enable them first"),
    b.IS_MOVING: (NotReady, "the motors are moving; wait or stop"),
    b.ESTOP_OPEN: (EmergencyStop, "the e-stop is pressed or its wire is open; release the button"),
    b.ALARM_ON + b.ALL_MOTORS: (
        DriveAlarm,
        "all three drives report an alarm at once; look whether they have power, or disable the"
        " drives",
    ),
}
_ALARM = "the drive of motor{motor} reports an alarm; disable the drives or cycle their power"


class Host(Protocol):
    """Where a pulse player runs: in this process as a task, or in a process of its own."""

    board: b.Board

    def kick(self) -> None:
        """Give the player a chance to serve requests (or wait a moment for it to do so)."""

    def play(self) -> None:
        """Ticks have been pushed: play them."""

    def fault(self) -> str:
        """Why the player is gone for good; empty while it lives."""

    def close(self) -> None:
        """End the player and give back everything but the board."""


class PlayerStepOutput:
    """A StepOutput over any host. Threads may call it at the same time."""

    def __init__(self, host: Host, clock: Clock, minimum_period_ns: int):
        self._host, self._clock, self._board = host, clock, host.board
        self._minimum_period_ns = minimum_period_ns
        self._lock = threading.RLock()
        self._fence = b.Fence()
        self._due = np.frombuffer(self._board.due_ns, dtype=np.int64)
        self._codes = np.frombuffer(self._board.codes, dtype=np.uint8)
        self._collected = self._pushed = 0
        self._last_due_ns = 0
        self._sent: list[Ticks] = []
        self._last: OutputStatus | None = None

    @property
    def minimum_period_ns(self) -> int:
        """Ticks closer than this are refused by `push`."""
        return self._minimum_period_ns

    def enable(self) -> None:
        with self._lock:
            held = self.status().energised
            self._ask(b.ENABLE, "energise the drives")
        if not held:
            sleep_s(self._clock, ENABLE_SETTLE_S)

    def disable(self) -> None:
        self._ask(b.DISABLE, "release the drives")

    def push(self, ticks: Ticks) -> None:
        called_ns = self._clock.now_ns()
        with self._lock:
            self._may_push()
            if not len(ticks):
                return
            due_ns, codes = as_ticks(ticks)
            self._check_gaps(due_ns)
            room = self.room()
            if len(due_ns) > room:
                raise PulseFault(f"{len(due_ns)} ticks do not fit, there is room for {room}; wait")
            slots = (self._pushed + np.arange(len(due_ns))) & b.SLOT_MASK
            self._due[slots], self._codes[slots] = due_ns, codes
            self._fence()
            # Not the time now: a caller that hung in here must be seen to have been silent.
            words = self._board.words
            words[b.BEAT] = max(words[b.BEAT], called_ns)
            self._pushed += len(due_ns)
            words[b.PUSHED] = self._pushed
            self._last_due_ns = int(due_ns[-1])
            self._host.play()

    def room(self) -> int:
        with self._lock:
            self._collect()
            return b.CAPACITY - (self._pushed - self._collected)

    def status(self) -> OutputStatus:
        """See StepOutput. A player that is gone shows as STOPPED, with the reason."""
        with self._lock:
            if self._last is not None:
                return self._last
            self._host.kick()
            fault = self._host.fault()
            return self._status(bool(fault), fault)

    def take_sent(self) -> Ticks:
        with self._lock:
            self._collect()
            sent, self._sent = self._sent, []
        return Ticks.joined(sent)

    def set_counts(self, counts: Counts) -> None:
        self._ask(b.SET_COUNTS, "set the counters", counts)

    def switch(self, levels: int, mask: int) -> None:
        self._ask(b.SWITCH, "switch an output", (levels, mask, 0))

    def stop(self, reason: str) -> None:
        """See StepOutput. Never raises: a player that is gone has stopped."""
        with self._lock:
            if self._last is not None:
                return
            if self._board.words[b.STATE] != b.STOPPED:  # the first reason stays
                self._board.set_request(reason or "stop requested")
                self._fence()
            self._board.words[b.STOP] += 1
            give_up_s = time.monotonic() + ANSWER_S
            while self._board.words[b.STATE] != b.STOPPED and time.monotonic() < give_up_s:
                self._host.kick()
                if self._host.fault():
                    return

    def acknowledge(self) -> None:
        self._ask(b.ACKNOWLEDGE, "release the stop")

    def beat(self) -> None:
        with self._lock:
            if self._last is None:
                self._board.words[b.BEAT] = self._clock.now_ns()

    def close(self) -> None:
        """See StepOutput. Afterwards status and sent ticks can be had; raises what lines raise."""
        with self._lock:
            if self._last is not None:
                return
            self._board.words[b.CLOSE] = b.CLOSED
            try:
                self._host.close()
            finally:
                self._collect()
                self._last = self._status(ended=True)
                del self._due, self._codes
                self._board.release()

    def _status(self, ended: bool, fault: str = "") -> OutputStatus:
        words = self._board.words
        return OutputStatus(
            OutputState.STOPPED if ended else _STATES[words[b.STATE]],
            self._board.counts(self._fence),
            0 if ended else words[b.PUSHED] - words[b.PLAYED],
            words[b.SLIP],
            fault or self._board.reason_text(),
            bool(words[b.ENERGISED]),
            bool(fault),
            words[b.SWITCHED],
        )

    def _ask(self, kind: int, what: str, arguments: Counts = (0, 0, 0)) -> None:
        """Have the player do something. Raises what its answer means."""
        with self._lock:
            self._check_alive(what)
            words = self._board.words
            words[b.KIND] = kind
            for motor in range(3):
                words[b.ARGUMENTS + motor] = arguments[motor]
            self._fence()
            words[b.COMMAND] += 1
            give_up_s = time.monotonic() + ANSWER_S
            while words[b.SERVED] != words[b.COMMAND]:
                self._host.kick()
                self._check_alive(what)
                if time.monotonic() > give_up_s:
                    raise PulseFault(f"cannot {what}: the pulse player does not answer; restart")
            self._fence()
            self._explain(words[b.RESULT], what)

    def _explain(self, result: int, what: str) -> None:
        if result != b.DONE:
            alarm = DriveAlarm, _ALARM.format(motor=result - b.ALARM_ON)
            kind, why = _REFUSED.get(result, alarm)
            raise kind(f"cannot {what}: {why.replace('{why}', self._board.reason_text())}")

    def _check_alive(self, what: str) -> None:
        fault = "closed" if self._last is not None else self._host.fault()
        if fault:
            raise PulseFault(f"cannot {what}: {fault}; start the step output again and home")

    def _may_push(self) -> None:
        self._check_alive("queue ticks")
        state = self._board.words[b.STATE]
        if state == b.STOPPED:
            self._explain(b.IS_STOPPED, "queue ticks")
        if state == b.DISABLED:
            self._explain(b.IS_DISABLED, "queue ticks")

    def _check_gaps(self, due_ns: Int64Array) -> None:
        gaps = np.diff(due_ns)
        if self._board.words[b.PLAYED] != self._pushed:  # goes on where the queue ends
            gaps = np.diff(due_ns, prepend=self._last_due_ns)
        if not len(gaps):
            return
        shortest_ns = int(gaps.min())
        if shortest_ns <= 0:
            raise ValueError(f"ticks must be strictly increasing in time (gap of {shortest_ns} ns)")
        if shortest_ns + 1 < self._minimum_period_ns:  # due times are rounded to whole ns
            raise LimitExceeded(
                f"two ticks are {shortest_ns / 1000:g} us apart, this step output takes "
                f"{self._minimum_period_ns / 1000:g} us or more; use a longer step period"
            )

    def _collect(self) -> None:
        """Take what was sent out of the ring, which makes room in it."""
        if self._last is not None:
            return
        played = self._board.words[b.PLAYED]
        if played == self._collected:
            return
        self._fence()
        slots = np.arange(self._collected, played) & b.SLOT_MASK
        codes = self._codes[slots]
        sent = stepping(codes)
        if sent.any():
            self._sent.append(Ticks(self._due[slots][sent], as_steps(codes[sent])))
        self._collected = played
