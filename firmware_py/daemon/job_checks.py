"""Jobs that are read, checked and planned, one after another, in a thread of its own.

Whoever sent one waits for it as long as a request may take to be answered, and asks for its
result afterwards.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable

from deltactl.firmware_py.controller.claim import Claim
from deltactl.firmware_py.wire_errors import as_exception, as_message
from deltactl.foundation.errors import DeltactlError, NotReady

KEPT = 2000
"""So many refusals are remembered: whoever waits for one asks within seconds."""

_log = logging.getLogger(__name__)


class JobCheck:
    """One accepted job and, once its check has ended, why it was refused."""

    def __init__(self, claim: Claim, check: Callable[[], None]):
        self.claim = claim
        self._check = check
        self._ended = threading.Event()
        self._refusal: DeltactlError | None = None

    def carry_out(self) -> None:
        """Check the job; what that raises is kept."""
        try:
            self._check()
        except DeltactlError as error:
            self._refusal = error
        except Exception as error:
            _log.exception("the check of job %d failed", self.claim.number)
            self._refusal = as_exception(as_message(error))
        self._ended.set()

    def wait(self, timeout_s: float) -> bool:
        """Whether it ends within that time."""
        return self._ended.wait(min(timeout_s, threading.TIMEOUT_MAX))

    @property
    def going_on(self) -> bool:
        """Whether nobody knows yet what comes of it."""
        return not self._ended.is_set() and not self.claim.called_off

    @property
    def refusal(self) -> DeltactlError | None:
        """Why the job never waits to be run; None while nobody knows, and where it was queued."""
        if self._ended.is_set():
            return self._refusal
        why = self.claim.called_off
        return NotReady(f"cannot run: {why}") if why else None


class JobChecks:
    """Carries out checks in the order in which the jobs were accepted. Any thread may call."""

    def __init__(self, most_waiting: int):
        self._most = most_waiting
        self._changed = threading.Condition()
        self._waiting: deque[JobCheck] = deque()
        """The first is the one that is carried out."""
        self._by_number: dict[int, JobCheck] = {}
        """Those that wait, and those that were refused."""
        self._closed = False
        self._thread = threading.Thread(target=self._work, name="checks", daemon=True)

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    @property
    def alive(self) -> bool:
        """Whether checks are still carried out."""
        return self._thread.is_alive()

    def must_have_room(self) -> None:
        """Raise NotReady where too many wait already."""
        with self._changed:
            if len(self._waiting) > self._most:
                raise NotReady(f"cannot run: {self._most} jobs are to be planned; try again later")

    def put(self, claim: Claim, check: Callable[[], None]) -> JobCheck:
        """Have an accepted job checked when its turn comes."""
        made = JobCheck(claim, check)
        with self._changed:
            self._waiting.append(made)
            self._by_number[claim.number] = made
            self._changed.notify()
        return made

    def of(self, number: int) -> JobCheck | None:
        """The check of a job that was not queued, or not yet; None of any other."""
        with self._changed:
            return self._by_number.get(number)

    def call_off(self, why: str) -> int:
        """None of these jobs moves any more. Returns of how many nobody knew yet what comes."""
        with self._changed:
            open_checks = [check for check in self._waiting if check.going_on]
        for check in open_checks:
            check.claim.call_off(why)
        with self._changed:  # all but the first, which is carried out, make room
            waiting = enumerate(self._waiting)
            self._waiting = deque(check for n, check in waiting if n == 0 or check.going_on)
        return len(open_checks)

    def close(self, timeout_s: float) -> None:
        """End; what was not called off before is checked no more."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self.alive:
            self._thread.join(timeout_s)

    def _work(self) -> None:
        while (check := self._next()) is not None:
            check.carry_out()
            with self._changed:
                self._waiting.popleft()
                self._forget(check)

    def _next(self) -> JobCheck | None:
        with self._changed:
            while not self._waiting and not self._closed:
                self._changed.wait()
            return self._waiting[0] if self._waiting and not self._closed else None

    def _forget(self, check: JobCheck) -> None:
        """Keep the newest refusals, and none of a job that was queued."""
        if check.refusal is None:
            del self._by_number[check.claim.number]
        refused = len(self._by_number) - len(self._waiting)
        for number in tuple(self._by_number)[: max(0, refused - KEPT)]:
            del self._by_number[number]
