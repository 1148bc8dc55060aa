"""What makes a process punctual: priority, locked memory, no collector, exact sleep.

Each measure is asked for and done without if it is refused; the board says which were granted.
"""

from __future__ import annotations

import ctypes
import gc
import os
import signal
from pathlib import Path
from time import monotonic_ns, sleep

from deltactl.drivers.steps.board import GOT_FIFO, GOT_LOCKED_MEMORY, GOT_OWN_CORE

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
