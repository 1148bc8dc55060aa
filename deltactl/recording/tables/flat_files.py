"""Any flat recording by its name: `.csv`, `.csv.gz`, `.parquet`, `.mat`, or a whole `.mcap` run."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import make_reader

from deltactl.foundation.errors import RecordingError
from deltactl.recording.format.channels import WRITTEN_BY
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.scan import begins_as_mcap
from deltactl.recording.tables.binary_tables import (
    parquet_columns,
    read_mat,
    write_mat,
    write_parquet,
)
from deltactl.recording.tables.csv_table import read_csv, write_csv
from deltactl.recording.tables.flat import FlatRecording, from_columns
from deltactl.recording.tables.rounds import flatten

Progress = Callable[[str], None]
MOST_BYTES = 2**26
"""Messages of a recorded run that are read for its table: half an hour. For a longer one,
stretches spread over all of it."""


READERS: dict[str, Callable[[Path, Progress], FlatRecording]] = {
    ".csv": read_csv,
    ".csv.gz": read_csv,
    ".parquet": lambda path, _: from_columns(parquet_columns(path), str(path)),
    ".mat": lambda path, _: read_mat(path),
    ".mcap": lambda path, progress: flatten(read_run(path, MOST_BYTES, progress)),
}
WRITERS: dict[str, Callable[[FlatRecording, Path], None]] = {
    ".csv": write_csv,
    ".csv.gz": write_csv,
    ".parquet": write_parquet,
    ".mat": write_mat,
}


def read_flat(path: Path, progress: Progress = lambda _: None) -> FlatRecording:
    """Read a flat recording, or flatten a recorded run: of one of a day, stretches.

    Raises RecordingError (one line, with file and row) for anything that is not one.
    """
    try:
        ending = _ending(path, READERS)
    except RecordingError as error:
        typed = f"; another table is read with --set: type: deltactl inspect {path}"
        raise error.with_typed(typed) from None
    return READERS[ending](path, progress)


def is_own_run(path: Path) -> bool:
    """Whether a path is a run that this program recorded, by the first words of the file."""
    try:
        with path.open("rb") as stream:
            if not begins_as_mcap(stream):
                return False
            return str(make_reader(stream).get_header().library).startswith(WRITTEN_BY)
    except (OSError, McapError, struct.error):  # no file, another one, or one cut short
        return False


def write_flat(recording: FlatRecording, path: Path) -> None:
    """Write a flat recording; replaces the file. Raises RecordingError."""
    WRITERS[_ending(path, WRITERS)](recording, path)


def _ending(path: Path, known: Iterable[str]) -> str:
    name = path.name.lower()
    for ending in sorted(known, key=len, reverse=True):
        if name.endswith(ending):
            return ending
    raise RecordingError(
        f"{path}: the name must end in {', '.join(known)}, which says how it is read or written"
    )
