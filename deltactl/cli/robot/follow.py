"""Follow a job to its end with a progress bar, whether the daemon or this process runs it."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

from deltactl.cli.output import errors, warn
from deltactl.firmware_py.controller.contract import JobResult, RobotController, Status
from deltactl.firmware_py.controller.states import State
from deltactl.foundation.clock import Clock, sleep_s

Sleep = Callable[[float], None]

SHOW_AFTER_S = 0.05
"""Shortest time between two redraws of the progress [s]."""


def follow(
    controller: RobotController, job_id: int, sleep: Sleep, every_s: float, quiet: bool
) -> JobResult:
    """Wait for a job. Ctrl-C decelerates and cancels it; what was recorded is kept."""
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
        console=errors,
        disable=quiet or not errors.is_terminal,
        transient=True,
    ) as progress:
        bar = progress.add_task("starting", total=1.0, left="")
        drawn_s, paused = 0.0, ""
        while (result := controller.result(job_id)) is None:
            try:
                sleep(every_s)
                if time.monotonic() - drawn_s > SHOW_AFTER_S:
                    drawn_s = time.monotonic()
                    status = controller.status()
                    _draw(progress, bar, status)
                    why = status.why if status.state == State.PAUSED.value else ""
                    if why != paused and why:
                        warn(f"the job pauses ({why}); 'deltactl resume' goes on")
                    paused = why
            except KeyboardInterrupt:
                warn("cancelling: the robot decelerates on the path")
                controller.cancel(job_id)
    return result


def _draw(progress: Progress, bar: object, status: Status) -> None:
    left = "" if status.seconds_left is None else f"{status.seconds_left:.0f} s of robot time left"
    name = f"{status.state}: {status.job}" if status.job else status.state
    progress.update(bar, completed=status.progress, description=name, left=left)  # type: ignore[arg-type]


@contextmanager
def interrupted_between_sleeps(clock: Clock) -> Iterator[Sleep]:
    """A sleep after which Ctrl-C or SIGTERM is raised as KeyboardInterrupt, and never within it.

    On a virtual clock the robot's own loops run while the caller sleeps: an exception in one of
    them would end it, and the robot could not decelerate.
    """
    asked: list[int] = []

    def sleep(duration_s: float) -> None:
        sleep_s(clock, duration_s)
        if asked:
            asked.clear()
            raise KeyboardInterrupt

    signals = (signal.SIGINT, signal.SIGTERM)
    before = {one: signal.signal(one, lambda number, _: asked.append(number)) for one in signals}
    try:
        yield sleep
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
