"""The jobs of one controller: those that wait, the one that runs, and how the others ended."""

from __future__ import annotations

import itertools
import threading
from collections import deque
from collections.abc import Callable

from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.controller.jobs.active_job import ActiveJob
from deltactl.firmware_py.controller.jobs.job_queue import QueuedJob
from deltactl.firmware_py.controller.jobs.results import Results
from deltactl.foundation.clock import Clock, Task
from deltactl.foundation.errors import NotReady

MOST_QUEUED = 100
"""A queued job holds its whole plan in memory."""


class Jobs:
    """Every call but `result` comes with the controller's lock held."""

    def __init__(
        self, clock: Clock, lock: threading.RLock, on_error: Callable[[BaseException], None]
    ):
        """`on_error` hears of what a recording's end raises."""
        self.running: ActiveJob | None = None
        self.queue: deque[QueuedJob] = deque()
        self._clock = clock
        self._lock = lock
        self._on_error = on_error
        self._numbers = itertools.count(1)
        self._results = Results()
        self._unfinished: list[tuple[ActiveJob, str, str]] = []
        """Jobs that have ended and whose recordings are not closed yet."""

    def next_number(self) -> int:
        """For a job that is about to be prepared."""
        return next(self._numbers)

    def add(self, job: QueuedJob) -> None:
        """Last in the queue. Raises NotReady when that is full."""
        if len(self.queue) >= MOST_QUEUED:
            raise NotReady(f"cannot run: {MOST_QUEUED} jobs wait already; let some end first")
        self.queue.append(job)

    def waiting(self, job_id: int | None) -> list[QueuedJob]:
        """The job of that number if it waits; without a number, all that wait."""
        return [one for one in self.queue if job_id in (None, one.number)]

    def runs(self, job_id: int | None) -> bool:
        """Whether that job runs now; without a number, whether any does."""
        return self.running is not None and job_id in (None, self.running.number)

    def drop(self, jobs: list[QueuedJob]) -> None:
        """Cancel jobs that wait."""
        for waiting in jobs:
            self.queue.remove(waiting)
            self.never_ran(waiting, "cancelled", "cancelled while queued")

    def never_ran(self, job: QueuedJob, outcome: str, why: str) -> None:
        """Note how a job ended that never ran."""
        self._results.never_ran(job.number, job.name, outcome, why)

    def result(self, job_id: int) -> JobResult | None:
        """How a job ended; None while it is queued or running."""
        return self._results.of(job_id)

    def end_all(self, outcome: str, why: str) -> None:
        """The one that runs is broken off, and none that waits will run."""
        if self.running is not None:
            job, self.running = self.running, None
            job.abort()
            self.finish_later(job, outcome, why)
        for waiting in self.queue:
            self.never_ran(waiting, outcome, why)
        self.queue.clear()

    def finish_later(self, job: ActiveJob, outcome: str, why: str) -> None:
        """In a task of its own: a disk may take seconds, and nothing must wait for it."""

        def task() -> Task:
            yield self._clock.now_ns()
            self._finish(job, outcome, why)

        self._unfinished.append((job, outcome, why))
        self._clock.start("closing", task(), self._on_error)

    def finish_now(self) -> None:
        """Close the recordings that are still open; called without the lock."""
        for ended in tuple(self._unfinished):
            self._finish(*ended)

    def _finish(self, job: ActiveJob, outcome: str, why: str) -> None:
        """The recording first: who has the result reads it."""
        job.close_recording()
        with self._lock:
            self._results.ran(job, outcome, why)
            if (job, outcome, why) in self._unfinished:
                self._unfinished.remove((job, outcome, why))
