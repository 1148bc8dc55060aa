"""What a reproduction prints, writes, and keeps of its long stages."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.charts.page import paragraph, table
from deltactl.foundation.errors import RecordingError
from deltactl.foundation.plain_file import check_place, whole_file, write_whole


@dataclass(frozen=True)
class Sheet:
    """Columns from `numbers_from` on are numbers; `note` comes below."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    numbers_from: int = 1
    note: str = ""

    def text(self) -> str:
        """For the screen: aligned columns that no window's edge breaks."""
        lines = [self.head, *self.rows]
        widths = [max(len(line[column]) for line in lines) for column in range(len(self.head))]
        drawn = [
            "  ".join(
                cell.rjust(width) if column >= self.numbers_from else cell.ljust(width)
                for column, (cell, width) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
            for line in lines
        ]
        rule = "─" * (sum(widths) + 2 * len(widths) - 2)
        body = "\n".join([drawn[0], rule, *drawn[1:]])
        return f"{self.title}\n\n{body}\n" + (f"{self.note}\n" if self.note else "")

    def markdown(self) -> str:
        """For docs."""
        ruler = [
            "---:" if column >= self.numbers_from else "---" for column in range(len(self.head))
        ]
        lines = [self.head, ruler, *self.rows]
        body = "\n".join("| " + " | ".join(line) + " |" for line in lines)
        return f"**{self.title}**\n\n{body}\n" + (f"\n{self.note}\n" if self.note else "")

    def html(self) -> str:
        """For the report."""
        note = paragraph(self.note, "note") if self.note else ""
        return table(self.head, self.rows, self.numbers_from, self.title) + note


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


Arrays = dict[str, np.ndarray[Any, Any]]
MARK = "mark"


def kept(path: Path, mark: str, make: Callable[[], Arrays]) -> Arrays:
    """Arrays of `path` (.npz) if it carries this mark; made and written otherwise.

    mark: everything the result depends on, in one line. Raises RecordingError on a full disk.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            found = {name: file[name] for name in file.files}
        if str(found.pop(MARK, "")) == mark:
            return found
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        pass
    made = make()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as stream:
            np.savez(stream, **{MARK: np.array(mark), **made})
    except OSError as error:
        raise RecordingError(
            f"{path}: cannot be written ({error.strerror or error}); make room, the same command "
            "goes on from here"
        ) from error
    return made
