"""What a reproduction prints and writes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from foundation.errors import RecordingError
from reproduction.sheet import Sheet

REPORT, TABLES = "report.html", "tables.md"


@dataclass(frozen=True)
class Outcome:
    """Tables for the screen, and where report and tables are."""

    sheets: list[Sheet]
    report: Path
    tables: Path


def write(folder: Path, sheets: list[Sheet], html: str, markdown: str) -> Outcome:
    """Write report and tables. Raises RecordingError when they cannot be written."""
    outcome = Outcome(sheets, folder / REPORT, folder / TABLES)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for path, text in ((outcome.tables, markdown), (outcome.report, html)):
            partial = path.with_suffix(".partial")
            partial.write_text(text, encoding="utf-8")
            partial.replace(path)
    except OSError as error:
        raise RecordingError(
            f"{folder}: cannot be written ({error.strerror or error}); what is done is kept, the "
            "same command goes on from there"
        ) from error
    return outcome
