"""Files that a command is given: what must be there, what is not written over, whose robot."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.output import warn
from deltactl.foundation.errors import ConfigError, DeltactlError, RecordingError
from deltactl.foundation.plain_file import undone_on_failure, write_whole

ForceOption = Annotated[
    bool, typer.Option("--force", help="Overwrite existing files; never a recording.")
]


def refuse_recorded(path: Path | None) -> None:
    """Raise ConfigError for a recording that is there: --force is for what can be made again."""
    if path is not None and path.exists():
        raise ConfigError(
            f"{path}: exists already; a recording is never written over, not with --force either:"
            " name another file, or move it away"
        )


def refuse_existing(force: bool, *paths: Path | None) -> None:
    """Raise ConfigError for files that would be written over; empty ones hold nothing to lose."""
    if force:
        return
    for path in paths:
        if path is not None and path.is_file() and path.stat().st_size:
            raise ConfigError(f"{path}: exists already; name another file, or add --force")


def refuse_other_page(*paths: Path | None) -> None:
    """Raise ConfigError for a report whose name promises another kind of file."""
    for path in paths:
        if path is not None and path.suffix.lower() not in ("", ".html", ".htm"):
            raise ConfigError(
                f"{path}: a report is one HTML file; name it {path.with_suffix('.html')}"
                " (a browser prints it as PDF)"
            )


@contextmanager
def written_if_right(path: Path, text: str, otherwise: str = "") -> Iterator[None]:
    """Write a file for what is done with it within; where that is refused, what was before is back.

    otherwise: what is then said behind the refusal.
    """
    try:
        with undone_on_failure(path):
            write_whole(path, text)
            yield
    except DeltactlError as error:
        if otherwise and len(error.args) == 1:
            raise error.worded(f"{error}; {otherwise}") from error
        raise


def refuse_missing(recordings: Iterable[Path]) -> None:
    """Raise RecordingError for the first file or folder that is not there."""
    import difflib

    for path in recordings:
        if path.exists():
            continue
        folder = path.parent
        there = [entry.name for entry in folder.iterdir()] if folder.is_dir() else []
        close = difflib.get_close_matches(path.name, there, n=1, cutoff=0.75)
        hint = f"; did you mean '{folder / close[0]}'?" if close else ""
        raise RecordingError(f"{path}: no such file{hint}")


def robot_or_here(named: str | None) -> str:
    """The file that was named, else the only one of this folder, else the example.

    Says on standard error which one is taken. Raises ConfigError where several could be meant.
    """
    if named is not None:
        return named
    from deltactl.firmware_py.named_files import EXAMPLE, robots_here

    here = robots_here()
    if len(here) > 1:
        say = " or ".join(f"--robot {name}" for name in here)
        raise ConfigError(f"{len(here)} robot files are in this folder; add {say}")
    if here:
        warn(f"Robot file: {here[0]}, the one in this folder.")
        return here[0]
    warn(f"Robot file: {EXAMPLE}, the example; --robot names another.")
    return EXAMPLE
