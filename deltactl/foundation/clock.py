"""Time as a seam: a real clock on the robot, a virtual one in simulation and tests.

A task is a generator that yields the time (ns, on the clock) at which it wants to be
woken. The real clock gives every task a thread; the virtual clock runs all tasks in
the caller's thread, in the order of their deadlines, so a run is deterministic.
"""

from __future__ import annotations

import heapq
import itertools
import threading
import time
from collections.abc import Callable, Generator
from typing import Protocol

NS_PER_S = 1_000_000_000

Task = Generator[int, None, None]
"""Yields the next wake-up time in ns; returning ends the task."""


def ns(seconds: float) -> int:
    """Seconds as whole nanoseconds."""
    return round(seconds * NS_PER_S)


class TaskHandle:
    """A started task: whether it is done, and the error that ended it, if any."""

    def __init__(self, name: str, task: Task, on_error: Callable[[BaseException], None] | None):
        self.name = name
        self.error: BaseException | None = None
        self.done = False
        self._task = task
        self._on_error = on_error
        self._stopped = threading.Event()

    def stop(self) -> None:
        """Ask the task to end; it is not resumed again."""
        self._stopped.set()

    def resume(self) -> int | None:
        """Run the task up to its next yield; returns the wake-up time, None when it has ended."""
        if self._stopped.is_set():
            self._task.close()
            self.done = True
            return None
        try:
            return next(self._task)
        except StopIteration:
            self.done = True
        except Exception as error:
            self.error, self.done = error, True
            if self._on_error is None:
                raise
            self._on_error(error)
        return None


class Clock(Protocol):
    """Tells the time, sleeps, and wakes tasks when they asked to be woken."""

    def now_ns(self) -> int:
        """Nanoseconds since an arbitrary start; never goes back."""

    def sleep_until_ns(self, wake_ns: int) -> None:
        """Return when `now_ns() >= wake_ns`; other tasks run meanwhile."""

    def start(
        self, name: str, task: Task, on_error: Callable[[BaseException], None] | None = None
    ) -> TaskHandle:
        """Run `task` beside the caller. Without `on_error` its error is raised where it ran."""


def sleep_s(clock: Clock, duration_s: float) -> None:
    """Sleep for a duration on any clock."""
    clock.sleep_until_ns(clock.now_ns() + ns(duration_s))


class RealClock:
    """The machine's monotonic clock; every task is a daemon thread."""

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def sleep_until_ns(self, wake_ns: int) -> None:
        while (left_ns := wake_ns - time.monotonic_ns()) > 0:
            time.sleep(left_ns / NS_PER_S)

    def start(
        self, name: str, task: Task, on_error: Callable[[BaseException], None] | None = None
    ) -> TaskHandle:
        handle = TaskHandle(name, task, on_error)

        def body() -> None:
            while (wake_ns := handle.resume()) is not None:
                self.sleep_until_ns(wake_ns)

        threading.Thread(target=body, name=name, daemon=True).start()
        return handle


class VirtualClock:
    """Time that moves only when somebody sleeps; tasks run in deadline order in one thread.

    Does not model: threads running at the same instant, or code taking time to run.
    """

    def __init__(self, start_ns: int = 0):
        self._now_ns = start_ns
        self._order = itertools.count()
        self._due: list[tuple[int, int, TaskHandle]] = []

    def now_ns(self) -> int:
        return self._now_ns

    def sleep_until_ns(self, wake_ns: int) -> None:
        while self._due and self._due[0][0] <= wake_ns:
            due_ns, _, handle = heapq.heappop(self._due)
            self._now_ns = max(self._now_ns, due_ns)
            self._schedule(handle)
        self._now_ns = max(self._now_ns, wake_ns)

    def start(
        self, name: str, task: Task, on_error: Callable[[BaseException], None] | None = None
    ) -> TaskHandle:
        handle = TaskHandle(name, task, on_error)
        heapq.heappush(self._due, (self._now_ns, next(self._order), handle))
        return handle

    def _schedule(self, handle: TaskHandle) -> None:
        wake_ns = handle.resume()
        if wake_ns is not None:
            heapq.heappush(self._due, (max(wake_ns, self._now_ns), next(self._order), handle))
