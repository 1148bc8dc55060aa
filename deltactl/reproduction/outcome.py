"""What a reproduction prints and writes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import check_place, write_whole
from deltactl.reproduction.sheet import Sheet

REPORT, TABLES = "report.html", "tables.md"


@dataclass(frozen=True)
class Outcome:
    """Tables for the screen, and where report and tables are."""

    sheets: list[Sheet]
    report: Path
    tables: Path


def check_writable(folder: Path) -> None:
    """Before any work: raise RecordingError where nothing could be written in the end."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        check_place(folder / REPORT)
    except OSError as error:
        raise _unwritable(folder, error) from error


def write(folder: Path, sheets: list[Sheet], html: str, markdown: str) -> Outcome:
    """Write report and tables. Raises RecordingError when they cannot be written."""
    outcome = Outcome(sheets, folder / REPORT, folder / TABLES)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path, text in ((outcome.tables, markdown), (outcome.report, html)):
            write_whole(path, text)
    except OSError as error:
        raise _unwritable(folder, error) from error
    return outcome


def _unwritable(folder: Path, error: OSError) -> RecordingError:
    return RecordingError(
        f"{folder}: cannot be written ({error.strerror or error}); make room or name another "
        "folder with --out, and give the command again"
    )
