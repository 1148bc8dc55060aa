"""The pulse player as tasks of a clock, inside the process that calls it.

On a virtual clock this is exact at any step period. On the real clock it is a Python thread
among others: good enough from 2 ms on, never faster.
"""

from __future__ import annotations

import threading
from collections.abc import Generator

from deltactl.drivers.steps.board import BOARD_BYTES, CLOSED, LINE_FAULT, Board
from deltactl.drivers.steps.lines import LineGroup
from deltactl.drivers.steps.output import PlayerStepOutput
from deltactl.drivers.steps.player import PulsePlayer
from deltactl.drivers.steps.timing import PlayerSettings
from deltactl.foundation.clock import Clock, Task, TaskHandle

WATCH_NS = 10_000_000
"""While nothing moves, inputs are looked at this often."""


class TaskHost:
    """One task watches the inputs; another plays while there is something to play."""

    def __init__(self, lines: LineGroup, settings: PlayerSettings, clock: Clock):
        self.board = Board(bytearray(BOARD_BYTES))
        self._lines, self._clock = lines, clock
        self._player = PulsePlayer(self.board, lines, settings, clock.now_ns)
        self._lock = threading.RLock()
        self._motion: TaskHandle | None = None
        self._plays: Generator[int, None, None] | None = None
        self._playing = self._closed = False
        self._fault = ""
        self._watch = clock.start("pulse inputs", self._watching())

    def kick(self) -> None:
        """Serve requests here and now."""
        with self._lock:
            if self._closed:
                return
            try:
                self._player.serve()
            except Exception as error:  # whatever it is, motion must end
                self._fail(error)

    def play(self) -> None:
        """Start a task that plays, unless one is at it."""
        with self._lock:
            if not self._playing and not self._closed:
                self._playing = True
                self._plays = self._player.play()
                self._motion = self._clock.start("pulses", self._moving(self._plays))

    def fault(self) -> str:
        """What the lines reported when they failed."""
        return self._fault

    def close(self) -> None:
        """Stop, leave STEP low, and close the lines. Raises what the lines raise."""
        with self._lock:
            self._closed = True
            self._watch.stop()
            if self._motion is not None:
                self._motion.stop()
            try:
                if self._plays is not None:
                    self._plays.close()
                self._player.make_safe(CLOSED)
            finally:
                self._lines.close()

    def _watching(self) -> Task:
        while not self._closed and not self._fault:
            if not self._playing:
                self.kick()
            yield self._clock.now_ns() + WATCH_NS

    def _moving(self, plays: Generator[int, None, None]) -> Task:
        while True:
            with self._lock:
                try:
                    wake_ns = next(plays, None)
                except Exception as error:
                    self._fail(error)
                    wake_ns = None
                if wake_ns is None:
                    self._playing = False
                    return
            yield wake_ns

    def _fail(self, error: Exception) -> None:
        self._fault = f"the step lines failed ({error})"
        self._player.stop(LINE_FAULT)


class TaskStepOutput(PlayerStepOutput):
    """A StepOutput whose player runs in this process, as tasks of `clock`."""

    def __init__(
        self, lines: LineGroup, settings: PlayerSettings, clock: Clock, minimum_period_ns: int
    ):
        super().__init__(TaskHost(lines, settings, clock), clock, minimum_period_ns)
