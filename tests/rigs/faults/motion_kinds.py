"""Faults of drives, buttons, pulse process and interpreter: what must end the pulses."""

from __future__ import annotations

import ctypes
import os
import signal
from contextlib import suppress
from random import Random

from tests.rigs.faults.kind import Kind, Undo, nothing
from tests.rigs.faults.stand import Stand
from tests.rigs.faults.verdict import HEARTBEAT_S

STALL_S = 2.0
EDGE_S = 0.005


def press_estop(stand: Stand, chance: Random) -> Undo:
    """The button, or its wire."""
    stand.bench.press_estop()
    return stand.bench.release_estop


def trip_drive(stand: Stand, chance: Random) -> Undo:
    """A drive reports its alarm."""
    stand.bench.trip(chance.randint(1, 3))
    return stand.controller.power_off  # which clears the alarm


def command_stop(stand: Stand, chance: Random) -> Undo:
    """Somebody asks for an emergency stop."""
    stand.controller.stop("a hand in the way")
    return nothing


def kill_pulses(stand: Stand, chance: Random) -> Undo:
    """kill -9 of the pulse process."""
    os.kill(stand.pulse_pid, signal.SIGKILL)
    return nothing


def freeze_pulses(stand: Stand, chance: Random) -> Undo:
    """SIGSTOP of the pulse process; it is woken later, should it still be there."""
    pid = stand.pulse_pid
    os.kill(pid, signal.SIGSTOP)

    def wake() -> None:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGCONT)

    return wake


def lose_steps(stand: Stand, chance: Random) -> Undo:
    """A motor falls behind, or jumps ahead, by three to nine degrees of its arm."""
    steps = chance.choice((-1, 1)) * chance.randint(130, 400)
    stand.bench.slip(chance.randint(1, 3), steps)
    return nothing


def trip_all(stand: Stand, chance: Random) -> Undo:
    """All drives report at once, as with their common supply gone."""
    stand.bench.memory.ask_trips(7)
    return stand.controller.power_off


def drop_power(stand: Stand, chance: Random) -> Undo:
    """The drives lose their supply without a word: all arms sink by five to nine degrees."""
    for motor in (1, 2, 3):
        stand.bench.slip(motor, -chance.randint(220, 400))
    return nothing


def stall_drive(stand: Stand, chance: Random) -> Undo:
    """Something holds a motor, and its drive does not notice."""
    motor = chance.randint(1, 3)
    stand.bench.stall(motor)
    return lambda: stand.bench.stall(motor, False)


def stall_interpreter(stand: Stand, chance: Random) -> Undo:
    """Nobody else in this process gets the interpreter for two seconds."""
    ctypes.PyDLL(None).usleep(round(STALL_S * 1e6))  # PyDLL keeps the interpreter's lock
    return nothing


MOTION_KINDS = (
    Kind("e-stop pressed", press_estop, "stopped", EDGE_S, 0.2, "^e-stop$", "release the button"),
    Kind("drive alarm", trip_drive, "fault", EDGE_S, 0.2, "^alarm motor[123]$", "motor[123]"),
    Kind(
        "all drives alarm at once",
        trip_all,
        "fault",
        EDGE_S,
        0.2,
        "alarm of all three motors at once: drive power lost",
        "all three drives",
    ),
    Kind("drive power lost", drop_power, "fault", 1.0, 1.2, "lost steps: .*drive power lost"),
    Kind("steps lost", lose_steps, "fault", 1.0, 1.2, "lost steps: .* motor[123]"),
    Kind("motor held fast", stall_drive, "fault", 2.5, 2.7, "lost steps: .* motor[123]"),
    Kind("stop command", command_stop, "stopped", 0.01, 0.2, "a hand in the way"),
    Kind(
        "pulse process kill -9",
        kill_pulses,
        "fault",
        EDGE_S,
        0.3,
        "pulse process ended .signal 9",
        "pulse process ended",
        restart=True,
        uncounted=1,
    ),
    Kind(
        "pulse process SIGSTOP",
        freeze_pulses,
        "fault",
        EDGE_S,
        2.5,
        "pulse process hangs",
        "pulse process hangs",
        restart=True,
        uncounted=1,
    ),
    Kind(
        "interpreter stalls 2 s",
        stall_interpreter,
        "fault",
        HEARTBEAT_S + 0.02,
        STALL_S + 0.5,
        "no heartbeat",
    ),
)
