"""The steps of an installation: each says what it would do, and does it."""

from __future__ import annotations

import shlex
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from deltactl.foundation.errors import ServiceError
from deltactl.foundation.plain_file import write_whole

BACKUP = ".before-deltactl"
EVERYBODY_READS = 0o644
"""Permissions of a new file; one that is changed keeps its own."""


class Step(Protocol):
    """One thing to do. Doing it twice is harmless."""

    def describe(self) -> str:
        """What it would do, or that nothing is left to do; one line."""

    def apply(self) -> None:
        """Do it. Raises ServiceError."""


@dataclass(frozen=True, slots=True)
class WriteFile:
    """Put a text into a file; what stood there before is kept beside it."""

    path: Path
    text: str
    why: str

    def describe(self) -> str:
        before = text_of(self.path)
        if before == self.text:
            return f"keep     {self.path} (is as it should be)"
        if before is None:
            return f"write    {self.path} ({self.why})"
        return f"change   {self.path} ({self.why}); the old one is kept as {self._backup().name}"

    def apply(self) -> None:
        before = text_of(self.path)
        if before == self.text:
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            if before is not None:
                write_whole(self._backup(), before)
            # Also when the power goes: a Pi without config.txt does not boot.
            write_whole(self.path, self.text, mode=EVERYBODY_READS if before is None else None)
        except OSError as error:
            raise ServiceError(f"{self.path}: cannot be written ({error.strerror})") from error

    def _backup(self) -> Path:
        first = self.path.with_name(self.path.name + BACKUP)
        places = [first, *(first.with_name(f"{first.name}-{number}") for number in range(2, 1000))]
        return next(place for place in places if not place.exists())


@dataclass(frozen=True, slots=True)
class Run:
    """Run a command."""

    command: tuple[str, ...]
    why: str

    def describe(self) -> str:
        return f"run      {shlex.join(self.command)} ({self.why})"

    def apply(self) -> None:
        try:
            done = subprocess.run(self.command, capture_output=True, text=True, check=False)
        except OSError as error:
            raise ServiceError(f"{self.command[0]}: cannot be run ({error.strerror})") from error
        if done.returncode != 0:
            said = " ".join((done.stderr or done.stdout).split())[-300:]
            raise ServiceError(f"{shlex.join(self.command)}: failed ({said})")


def text_of(path: Path) -> str | None:
    """What stands in a file; None when there is none. Raises ServiceError."""
    try:
        return path.read_text()
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise ServiceError(f"{path}: cannot be read ({error})") from error
