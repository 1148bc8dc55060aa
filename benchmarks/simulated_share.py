"""The daemon with a stop watch on its simulated hardware; web_page.py starts it as `deltactl`.

`TALLY=FILE python -m benchmarks.simulated_share service daemon ROBOT.yaml --simulate ...`: as
`deltactl service daemon`, and FILE holds three 64-bit words: the processor time [ns] spent in the
fakes so far, in the daemon (bus, sensors, the robot they see) and in its pulse process (lines,
drives), and the rounds of the control loop. On a robot the kernel and the wires take the fakes'
place; what those cost is not known here.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import wraps
from mmap import mmap
from pathlib import Path
from time import thread_time_ns
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # loaded as late as the program itself does, which counts threads before numpy
    from deltactl.drivers.fakes.lines import FakeLines

TALLY = "TALLY"
DAEMON, PULSES, ROUNDS = 0, 1, 2
BYTES = 24
FAKE = "benchmarks.simulated_share:of_config"
"""Opens the lines in the pulse process in place of `deltactl.drivers.fakes.bench.FAKE`."""


def make_tally(path: Path) -> None:
    """An empty file for both words."""
    path.write_bytes(bytes(BYTES))


def tally(path: Path) -> tuple[float, int]:
    """Processor time in the fakes [s] and rounds of the control loop so far."""
    daemon_ns, pulses_ns, rounds = memoryview(path.read_bytes()).cast("q")
    return (daemon_ns + pulses_ns) / 1e9, rounds


def of_config(config: dict[str, Any]) -> FakeLines:
    """The fake lines, timed; called in the pulse process."""
    from deltactl.drivers.fakes import lines
    from deltactl.drivers.fakes.lines import FakeLines

    _time(PULSES, FakeLines, "read", "write")
    return lines.of_config(config)


def _time(word: int, kind: type[Any], *names: str) -> None:
    """Count the time in these methods, none of which calls another."""
    words = _words()
    for name in names:
        setattr(kind, name, _timed(getattr(kind, name), words, word))


def _words() -> memoryview:
    with open(os.environ[TALLY], "r+b") as file:
        return memoryview(mmap(file.fileno(), BYTES)).cast("q")


def _timed(method: Callable[..., Any], words: memoryview, word: int) -> Callable[..., Any]:
    @wraps(method)
    def timed(*given: Any, **named: Any) -> Any:
        start_ns = thread_time_ns()
        try:
            return method(*given, **named)
        finally:
            words[word] += thread_time_ns() - start_ns

    return timed


def _counted(method: Callable[..., Any], words: memoryview) -> Callable[..., Any]:
    @wraps(method)
    def counted(*given: Any) -> Any:
        words[ROUNDS] += 1
        return method(*given)

    return counted


def main() -> None:
    """Watch the fakes, then be `deltactl`; the pulse process, which has to start quickly, needs
    none of what is imported here."""
    from deltactl.cli.main import main as deltactl
    from deltactl.foundation.process import one_thread_in_this_program

    one_thread_in_this_program()
    from deltactl.drivers.fakes import bench
    from deltactl.drivers.fakes.i2c_bus import FakeI2cBus
    from deltactl.firmware_py.controller.control_loop import ControlLoop
    from deltactl.firmware_py.simulation.world import SimulatedRobot

    bench.FAKE = FAKE
    _time(DAEMON, FakeI2cBus, "i2c_rdwr")
    _time(DAEMON, SimulatedRobot, "truth", "keep_up")
    ControlLoop._round = _counted(ControlLoop._round, _words())  # type: ignore[method-assign]
    deltactl()


if __name__ == "__main__":
    main()
