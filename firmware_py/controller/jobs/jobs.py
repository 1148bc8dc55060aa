"""The jobs of one controller: those that wait, the one that runs, and how the others ended."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable

from deltactl.firmware_py.controller.claim import Claim
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.controller.jobs.active_job import ActiveJob
from deltactl.firmware_py.controller.jobs.job_queue import QueuedJob
from deltactl.firmware_py.controller.states import Ends, State
from deltactl.foundation.clock import Clock, Task
from deltactl.foundation.errors import NotReady, ServiceError

RESULTS_KEPT = 2000
"""So many results are remembered: whoever waits for one asks within seconds."""

_log = logging.getLogger(__name__)


class Results:
    """The results of the jobs that ended last, by their number."""

    def __init__(self) -> None:
        self._by_number: dict[int, JobResult] = {}

    def of(self, number: int) -> JobResult | None:
        """How a job ended; None while it is queued or running, or when it is forgotten."""
        return self._by_number.get(number)

    def never_ran(self, number: int, name: str, outcome: str, why: str) -> None:
        """Note how a job ended that never ran."""
        self._keep(JobResult(number, name, outcome, why, None))

    def ran(self, job: ActiveJob, outcome: str, why: str) -> None:
        """Note how a job ended that ran."""
        self._keep(
            JobResult(
                job.number,
                job.name,
                outcome,
                why,
                job.recording,
                job.recording_error,
                job.warning,
                job.slower,
            )
        )

    def _keep(self, result: JobResult) -> None:
        if result.outcome != "done":
            why = f": {result.why}" if result.why else ""
            _log.info("job %d '%s' %s%s", result.job_id, result.name, result.outcome, why)
        self._by_number[result.job_id] = result
        while len(self._by_number) > RESULTS_KEPT:
            del self._by_number[next(iter(self._by_number))]


MOST_QUEUED = 100
"""A queued job holds its whole plan in memory."""


Chosen = Callable[[Claim], bool]


def every(claim: Claim) -> bool:
    """All of them."""
    return True


class Jobs:
    """Every call but `result` comes with the controller's lock held."""

    def __init__(
        self, clock: Clock, lock: threading.RLock, on_error: Callable[[BaseException], None]
    ):
        """`on_error` hears of what a recording's end raises."""
        self.running: ActiveJob | None = None
        self.planned: list[Claim] = []
        """Claims of jobs that are being read, checked and planned."""
        self.queue: deque[QueuedJob] = deque()
        self.held = False
        """Whether somebody paused: nothing begins until it is resumed."""
        self._clock = clock
        self._lock = lock
        self._on_error = on_error
        self._last = 0
        self._results = Results()
        self._unfinished: list[tuple[ActiveJob, str, str]] = []
        """Jobs that have ended and whose recordings are not closed yet."""

    def state(self) -> State:
        """The state of a homed robot with these jobs; without any, nothing is held any more."""
        slowing = self.running is not None and self.running.cancelled
        if self.running is not None and (slowing or not self.held):
            return State.RUNNING
        if self.running is None and not self.planned and not self.queue:
            self.held = False
            return State.READY
        return State.PAUSED if self.held else State.PLANNING

    def plan(self, claim: Claim, name: str) -> None:
        """A job is taken and its check begins. Raises NotReady when it was called off already."""
        claim.must_hold("run")
        self._last += 1
        claim.number, claim.name = self._last, claim.name or name
        self.planned.append(claim)

    def add(self, job: QueuedJob) -> None:
        """It passed its check: last in the queue. Raises NotReady when that is full."""
        job.claim.must_hold("run")
        if len(self.queue) >= MOST_QUEUED:
            raise NotReady(f"cannot run: {MOST_QUEUED} jobs wait already; let some end first")
        self.planned.remove(job.claim)
        job.claim.accepted()
        self.queue.append(job)

    def move(self, number: int, place: int) -> None:
        """Put a job that waits at a place of the queue, from 1 on; beyond its end is the end."""
        found = next((job for job in self.queue if job.number == number), None)
        if found is None:
            raise NotReady(f"job {number} does not wait; see 'deltactl status'")
        self.queue.remove(found)
        self.queue.insert(max(0, place - 1), found)

    def refused(self, claim: Claim, why: str) -> bool:
        """It did not pass its check. Whether it was still planned, and not called off."""
        if claim not in self.planned:
            return False
        self.planned.remove(claim)
        outcome = "cancelled" if claim.called_off else "refused"
        self._results.never_ran(claim.number, claim.name, outcome, claim.called_off or why)
        return True

    def is_next(self, claim: Claim) -> bool:
        """Whether no job is before it."""
        return self.claims()[:1] == [claim]

    def pause(self, now_ns: int) -> None:
        """The one that runs decelerates on its path, and nothing begins."""
        self.held = True
        if self.running is not None and not self.running.cancelled:
            self.running.pause(now_ns)

    def resume(self, now_ns: int) -> None:
        """Go on."""
        self.held = False
        if self.running is not None:
            self.running.resume(now_ns)

    def known(self, job_id: int) -> bool:
        """Whether a job of that number is planned, waits or runs."""
        return any(one.number == job_id for one in self.claims())

    def claims(self) -> list[Claim]:
        """Claims of all jobs that have not ended, in the order in which they run."""
        running = [self.running.claim] if self.running is not None else []
        return [*running, *(one.claim for one in self.queue), *self.planned]

    def call_off(self, ends: Ends, why: str, chosen: Chosen = every) -> None:
        """Jobs that wait never run; the one that runs decelerates on its path."""
        if Ends.WAITING in ends:
            self._drop("cancelled", why, chosen)
        job = self.running
        if Ends.RUNNING in ends and job is not None and chosen(job.claim):
            job.claim.call_off(why)
            job.cancel(self._clock.now_ns(), why if job.claim.owner_gone else "")

    def _drop(self, outcome: str, why: str, chosen: Chosen = every) -> None:
        for claim in filter(chosen, tuple(self.planned)):
            self.planned.remove(claim)
            claim.call_off(why)
            self._results.never_ran(claim.number, claim.name, outcome, why)
        for waiting in [one for one in self.queue if chosen(one.claim)]:
            self.queue.remove(waiting)
            waiting.claim.call_off(why)
            self.never_ran(waiting, outcome, why)

    def never_ran(self, job: QueuedJob, outcome: str, why: str) -> None:
        """Note how a job ended that never ran."""
        self._results.never_ran(job.number, job.name, outcome, why)

    def result(self, job_id: int) -> JobResult | None:
        """How a job ended; None while it has not. Raises ServiceError where nobody knows it."""
        found = self._results.of(job_id)
        if found is None and not self.known(job_id):
            unfinished = any(one.number == job_id for one, _, _ in self._unfinished)
            if not unfinished:
                raise ServiceError(
                    f"the daemon knows no job {job_id}; it was restarted since, or that was long"
                    " ago"
                )
        return found

    def end_all(self, outcome: str, why: str) -> None:
        """The one that runs is broken off, and none that waits will run."""
        if self.running is not None:
            job, self.running = self.running, None
            job.claim.call_off(why)
            job.abort()
            self.finish_later(job, outcome, why)
        self._drop(outcome, why)
        self.held = False

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
