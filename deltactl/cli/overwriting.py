"""Files that are there are not written over, unless somebody says so."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from deltactl.foundation.errors import ConfigError, DeltactlError
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
