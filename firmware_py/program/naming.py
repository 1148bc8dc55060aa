"""What is wrong with a motion, told with the file that asks for it and not only the job's name."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from deltactl.foundation.errors import LimitExceeded, UnreachablePoint


@contextmanager
def told_with(job_file: Path | str) -> Iterator[None]:
    """Put the job file before whatever breaks a limit within."""
    try:
        yield
    except (LimitExceeded, UnreachablePoint) as error:
        raise error.worded(f"{job_file}: {error}") from error
