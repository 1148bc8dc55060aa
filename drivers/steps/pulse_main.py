"""The pulse process: `python -m deltactl.drivers.steps.pulse_main CONFIG`, started by hosts.py.

Owns lines and counters; ends with its controller, STEP low. Imports as little as it can. What makes
it punctual (priority, locked memory, a core of its own) is asked for and done without if it is
refused; the board says which were granted.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import signal
import sys
from importlib import import_module
from mmap import mmap
from pathlib import Path
from time import monotonic_ns, sleep
from typing import Any

from deltactl.drivers.steps import board as b
from deltactl.drivers.steps.board import GOT_FIFO, GOT_LOCKED_MEMORY, GOT_OWN_CORE
from deltactl.drivers.steps.lines import LineGroup
from deltactl.drivers.steps.player import PlayerSettings, PulsePlayer

PRIORITY = 40
"""Below the kernel's interrupt threads (50) of a PREEMPT_RT system."""
SPIN_NS = 60_000
"""The last part of a wait is spent looking at the clock: a sleep returns tens of us late."""
_PR_SET_PDEATHSIG, _PR_SET_TIMERSLACK = 1, 29  # linux/prctl.h
_MCL_CURRENT, _MCL_FUTURE = 1, 2  # sys/mman.h
_ISOLATED = Path("/sys/devices/system/cpu/isolated")


def become_punctual() -> int:
    """Ask for everything. Returns what was granted, as bits of the board's REALTIME word."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    gc.collect()
    gc.freeze()
    gc.disable()
    granted = GOT_LOCKED_MEMORY if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0 else 0
    return granted | _take_priority() | _take_own_core()


def die_with_parent(number: signal.Signals) -> None:
    """Have the kernel send a signal when the parent (more exactly, its starting thread) ends."""
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(number), 0, 0, 0)


def wait_until(wake_ns: int) -> None:
    """Return when the monotonic clock has reached `wake_ns`: sleep, then a short spin."""
    left_ns = wake_ns - monotonic_ns() - SPIN_NS
    if left_ns > 0:
        sleep(left_ns * 1e-9)
    while monotonic_ns() < wake_ns:
        pass


def doze_until(wake_ns: int) -> None:
    """As `wait_until` without the spin: some tens of us late, and half the processor time."""
    left_ns = wake_ns - monotonic_ns()
    if left_ns > 0:
        sleep(left_ns * 1e-9)


def _take_priority() -> int:
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError:
        return 0
    return GOT_FIFO


def _take_own_core() -> int:
    """Move to the last core that is isolated from the scheduler, if there is one."""
    try:
        cores = _ISOLATED.read_text().strip()
        if not cores:
            return 0
        os.sched_setaffinity(0, {int(cores.replace("-", ",").split(",")[-1])})
    except (OSError, ValueError):
        return 0
    return GOT_OWN_CORE


IDLE_S = 0.001
"""While nothing is to be played, inputs and requests are looked at this often."""


def open_lines(config: dict[str, Any]) -> LineGroup:
    """The line group that the controller named, as 'module:function' of the whole config.

    The lines of a fake bench are such a module too: this one need not know it.
    """
    module, _, function = config["lines"].partition(":")
    opened: LineGroup = getattr(import_module(module), function)(config)
    return opened


def watch_controller(words: memoryview, controller: int) -> None:
    """End when the controller does. A SIGTERM while it lives is its own affair, not ours."""

    def on_signal(*_: object) -> None:
        if os.getppid() != controller:
            words[b.CLOSE] = b.CONTROLLER_GONE

    for terminal in (signal.SIGINT, signal.SIGHUP):  # sent to the whole group
        signal.signal(terminal, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, on_signal)
    die_with_parent(signal.SIGTERM)
    on_signal()  # it may have ended before we asked to be notified


def remove_folder() -> None:
    """Nobody else is left to remove the folder we were started in."""
    from shutil import rmtree

    folder = os.getcwd()
    if os.path.basename(folder).startswith("deltactl-pulses-"):  # not one started by hand
        rmtree(folder, ignore_errors=True)


def run(player: PulsePlayer, words: memoryview) -> None:
    """Serve and play until asked to close."""
    while not words[b.CLOSE]:
        for wake_ns in player.play():
            if player.near_edge:
                wait_until(wake_ns)
            else:
                doze_until(wake_ns)
        player.serve()
        if not player.pending:
            sleep(IDLE_S)


def main(arguments: list[str]) -> int:
    """Exit status 0 when asked to end, 1 when the lines failed (the board says how)."""
    config = json.loads(arguments[0])
    board = b.Board(mmap(config["board"], b.BOARD_BYTES))
    words = board.words
    watch_controller(words, config["controller"])
    try:
        lines = open_lines(config)
        words[b.REALTIME] = become_punctual()
        player = PulsePlayer(board, lines, PlayerSettings(*config["settings"]), monotonic_ns)
    except OSError as error:
        board.set_fault(str(error))
        return 1
    try:
        run(player, words)
        player.make_safe(words[b.CLOSE])
        lines.close()
        if words[b.CLOSE] == b.CONTROLLER_GONE:
            remove_folder()
    except OSError as error:
        board.set_fault(str(error))
        player.stop(b.LINE_FAULT)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
