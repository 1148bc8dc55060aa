"""How jobs ended."""

from __future__ import annotations

import logging

from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.controller.jobs.active_job import ActiveJob

KEPT = 2000
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
        while len(self._by_number) > KEPT:
            del self._by_number[next(iter(self._by_number))]
