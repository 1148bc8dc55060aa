"""What has been answered so far: one line a recording, so that a fleet can be gone on with."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import RecordingError

Row = dict[str, Any]
NAME = "answers.jsonl"


def stamp_of(path: Path) -> str:
    """Changes when the file does."""
    its = path.stat()
    return f"{its.st_size}-{its.st_mtime_ns}"


class Book:
    """Answers in the order they came. A line that was cut off is forgotten, and done again."""

    def __init__(self, folder: Path):
        self._path = folder / NAME
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("a", encoding="utf-8")
        except OSError as error:
            raise RecordingError(f"{folder}: cannot be written ({error.strerror})") from error
        if self._path.stat().st_size and not self._path.read_bytes().endswith(b"\n"):
            self._file.write("\n")

    def add(self, row: Row) -> None:
        """Write an answer down, at once."""
        self._file.write(json.dumps(row, allow_nan=True) + "\n")
        self._file.flush()

    def rows(self) -> Iterator[Row]:
        """All answers; of a recording that was answered again, every one."""
        with self._path.open(encoding="utf-8") as lines:
            for line in lines:
                try:
                    row = json.loads(line)
                except ValueError:
                    continue
                if isinstance(row, dict) and "recording" in row:
                    yield row

    def done(self) -> dict[str, str]:
        """Recording -> stamp of the file that was answered."""
        return {row["recording"]: row["stamp"] for row in self.rows()}

    def close(self) -> None:
        """Give the file back."""
        self._file.close()
