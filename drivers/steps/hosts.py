"""Where the pulse player runs, and the step outputs that talk to it there.

As tasks of a clock inside the process that calls it: on a virtual clock this is exact at any step
period; on the real clock it is a Python thread among others, good enough from 2 ms on, never
faster. Or in a process of its own, which shares the board with this one.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Generator
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

from deltactl.drivers.steps import board as b
from deltactl.drivers.steps.board import BOARD_BYTES, CLOSED, LINE_FAULT, Board
from deltactl.drivers.steps.contract import Counts
from deltactl.drivers.steps.lines import LineGroup
from deltactl.drivers.steps.output import PlayerStepOutput
from deltactl.drivers.steps.player import PlayerSettings, PulsePlayer
from deltactl.foundation.clock import Clock, Task, TaskHandle
from deltactl.foundation.errors import ConfigError, MissingFile, PulseFault
from deltactl.foundation.process import importable

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


START_S = 10.0
SILENCE_NS = 2_000_000_000
"""A process that has not moved for so long hangs (it wakes every millisecond)."""


class PulseProcess:
    """A Host: the process, the board it shares with us, and whether it still lives.

    `lines` names the line group and what it needs, see pulse_main.open_lines. Raises
    PulseFault when the process does not come up.
    """

    def __init__(
        self,
        settings: PlayerSettings,
        lines: dict[str, Any],
        share: tuple[int, ...] = (),
        board_path: Path | None = None,
    ):
        descriptor = _board_file(board_path)
        try:
            self._block = mmap(descriptor, b.BOARD_BYTES)
            self.board = b.Board(self._block)
            config = {"controller": os.getpid(), "board": descriptor, "settings": settings} | lines
            self._folder = tempfile.TemporaryDirectory(prefix="deltactl-pulses-")
            self._process = _start(config, (descriptor, *share), self._folder.name)
        finally:
            os.close(descriptor)
        self._fault = ""
        try:
            self._await_start()
        except PulseFault:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """Process number."""
        return self._process.pid

    def kick(self) -> None:
        """Give the process a moment."""
        if self._waiting() and self._process.poll() is None:
            time.sleep(0.0002)

    def play(self) -> None:
        """Nothing to do: the process looks for ticks by itself."""

    def fault(self) -> str:
        """Why the process is of no more use; empty while all is well."""
        if self._fault:
            return self._fault
        status = self._process.poll()
        if status is not None:
            self._fault = self._epitaph(status)
        elif time.monotonic_ns() - self.board.words[b.ALIVE] > SILENCE_NS:
            self._fault = "the pulse process hangs"
            self.board.words[b.CLOSE] = b.CLOSED
            self._process.kill()  # should it wake up, it must not go on; and it frees its lines
        return self._fault

    def _waiting(self) -> bool:
        words = self.board.words
        asked_to_stop = words[b.STOP] != 0 and words[b.STATE] != b.STOPPED
        return asked_to_stop or words[b.COMMAND] != words[b.SERVED]

    def _await_start(self) -> None:
        give_up_s = time.monotonic() + START_S
        while self.board.words[b.MAGIC_WORD] != b.MAGIC:
            if self._process.poll() is not None:
                raise PulseFault(self.board.fault() or self._epitaph(self._process.returncode))
            if time.monotonic() > give_up_s:
                raise PulseFault(f"the pulse process did not start within {START_S:g} s")
            time.sleep(0.002)

    def _epitaph(self, status: int) -> str:
        how = f"signal {-status}" if status < 0 else f"status {status}"
        why = self.board.fault() or self._last_words()
        return f"the pulse process ended ({how}{': ' + why if why else ''})"

    def _last_words(self) -> str:
        """Last line of a traceback, which is the only thing the process ever prints."""
        stream = self._process.stderr
        if stream is None:
            return ""
        with stream:
            lines = stream.read().decode("utf-8", "replace").strip().splitlines()
        return lines[-1] if lines else ""

    def close(self) -> None:
        """End the process; by force when it does not listen."""
        self.board.words[b.CLOSE] = self.board.words[b.CLOSE] or b.CLOSED
        try:
            self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stderr is not None:
            self._process.stderr.close()
        self._folder.cleanup()


class ProcessStepOutput(PlayerStepOutput):
    """A StepOutput over a pulse process. Needs a clock that runs with the machine's own."""

    def __init__(self, host: PulseProcess, clock: Clock, minimum_period_ns: int):
        if abs(clock.now_ns() - time.monotonic_ns()) > 1_000_000_000:
            host.close()
            raise ConfigError("a pulse process plays in real time; it cannot follow this clock")
        super().__init__(host, clock, minimum_period_ns)
        self.process = host

    @property
    def realtime(self) -> str:
        """What the system granted the process, in words."""
        granted = self.process.board.words[b.REALTIME]
        names = {
            b.GOT_FIFO: "real-time priority",
            b.GOT_LOCKED_MEMORY: "locked memory",
            b.GOT_OWN_CORE: "a core of its own",
        }
        return ", ".join(name for bit, name in names.items() if granted & bit) or "nothing"


def last_counts(board_path: Path) -> Counts:
    """Counters that a pulse process left behind, say after a crash of the controller.

    Good for a report, not for going on: whoever starts again must home. Raises MissingFile.
    """
    try:
        with board_path.open("rb") as file:
            block = mmap(file.fileno(), b.BOARD_BYTES, access=ACCESS_READ)
        with contextlib.closing(block):
            words = memoryview(block)[: b.WORDS * 8].cast("q")
            counts = (words[b.COUNTS], words[b.COUNTS + 1], words[b.COUNTS + 2])
            words.release()
            return counts
    except (OSError, ValueError) as error:
        raise MissingFile(f"{board_path}: holds no step counters ({error})") from error


def _board_file(path: Path | None) -> int:
    """An empty file for the board: nameless, or one that stays when the processes are gone."""
    if path is None:
        descriptor = os.memfd_create("deltactl-pulses")
    else:
        path.unlink(missing_ok=True)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o640)
    os.ftruncate(descriptor, b.BOARD_BYTES)
    return descriptor


def _start(
    config: dict[str, Any], descriptors: tuple[int, ...], folder: str
) -> subprocess.Popen[bytes]:
    """Start Python on pulse_main; nothing of ours runs between fork and exec.

    lgpio leaves a pipe in the folder that LG_WD names.
    """
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "deltactl.drivers.steps.pulse_main", json.dumps(config)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        pass_fds=descriptors,
        cwd=folder,
        env=importable(dict(os.environ)) | {"LG_WD": folder},
    )
