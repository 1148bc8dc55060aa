"""How jobs ended."""

from __future__ import annotations

from firmware_py.controller.active_job import ActiveJob
from firmware_py.controller.contract import JobResult


class Results:
    """The result of every job that ended, by its number."""

    def __init__(self) -> None:
        self._by_number: dict[int, JobResult] = {}

    def of(self, number: int) -> JobResult | None:
        """How a job ended; None while it is queued or running."""
        return self._by_number.get(number)

    def never_ran(self, number: int, name: str, outcome: str, why: str) -> None:
        """Note how a job ended that never ran."""
        self._by_number[number] = JobResult(number, name, outcome, why, None)

    def ran(self, job: ActiveJob, outcome: str, why: str) -> None:
        """Note how a job ended that ran."""
        self._by_number[job.number] = JobResult(
            job.number, job.name, outcome, why, job.recording, job.recording_error, job.warning
        )
