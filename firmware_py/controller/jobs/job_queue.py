"""Jobs waiting to run: checked, planned, and with a place for their recording."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from pathlib import Path

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.controller.claim import Claim
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.planning.prepared import Prepared
from deltactl.firmware_py.program.instructions import Program
from deltactl.foundation.errors import RecordingError
from deltactl.recording.writing.retention import confined, fresh_path


@dataclass(frozen=True, slots=True)
class QueuedJob:
    """A job that passed its check."""

    claim: Claim
    name: str
    job_file: Path
    program: Program
    recording: Path
    robot_text: str
    job_text: str
    """What the recording carries with it."""

    @property
    def number(self) -> int:
        """By which it is cancelled, and its result asked for."""
        return self.claim.number

    @property
    def job(self) -> JobFile:
        """What was asked for."""
        return self.program.job

    def check_way_in(self, counts: Counts) -> None:
        """Refuse at once a move by hand, from where the arms are, that breaks a limit.

        That of a job that waits is checked when it begins. Raises UnreachablePoint, LimitExceeded.
        """
        plan = self.program.first
        if plan is not None and plan.way_in_mps is not None:
            plan.way_in(counts)


def queued(
    claim: Claim,
    job_file: Path,
    record: Path | None,
    prepared: Prepared,
    robot_text: str,
    recordings: Path,
    taken: Container[Path] = (),
) -> QueuedJob:
    """A prepared job with its claim, and a place for its recording. Raises RecordingError.

    taken: places of jobs that wait, where no file is yet.
    """
    job = prepared.program.job
    # Not beside the working directory: a service has none worth the name.
    chosen = record or (confined(recordings, job.record) if job.record else None)
    return QueuedJob(
        claim,
        job.name,
        job_file,
        prepared.program,
        _place(job.name, chosen, recordings, taken),
        robot_text,
        prepared.job_text,
    )


def _place(name: str, chosen: Path | None, recordings: Path, taken: Container[Path]) -> Path:
    """Where the recording goes; an existing file is never written over. Raises RecordingError."""
    if chosen is not None:
        path = chosen if chosen.suffix == ".mcap" else chosen.with_suffix(".mcap")
        if path in taken or path.exists():
            raise RecordingError(f"{path}: exists already; name another file, or move it away")
        return path
    return fresh_path(recordings, name, taken=taken)
