"""A table that is diagnosed and of which nobody said how it is read, and what is said of that."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from command_line.output import warn
from foundation.errors import RecordingError
from foundation.extras import needs
from recording.tables.flat_files import read_flat
from recording.tables.foreign_log import is_log
from recording.tables.table_format import first_cells

if TYPE_CHECKING:
    from models.robot import RobotModel
    from recording.tables.flat import FlatRecording

BINARY = (".parquet", ".mat")


def read_plain(path: Path, robot: RobotModel | None) -> FlatRecording:
    """A recording of which nothing is said: where its heading has our names behind other marks, or
    no times are needed, that is found out and told.

    Raises RecordingError; where it looks like another machine's than the robot file's, saying so.
    """
    try:
        return read_flat(path)
    except RecordingError as error:
        wrong = error
    if is_log(path) or path.suffix in BINARY or "t" in first_cells(path):
        raise wrong
    with needs("diagnosis", "tables of others"):
        from diagnosis.columns.mapping import Mapping, read_mapped
    told: list[str] = []
    try:
        recording = read_mapped(path, Mapping(), told.append)
    except RecordingError:
        raise _of_another_kind(path, robot) or wrong from None
    for line in told:
        warn(line)
    return recording


def _of_another_kind(path: Path, robot: RobotModel | None) -> RecordingError | None:
    """What is said of a table with names of its own that looks like another kind of machine."""
    from diagnosis.columns.inspection import inspect
    from diagnosis.columns.machine_kind import looks_like

    try:
        seen = inspect(path)
    except RecordingError:
        return None
    if robot is None or seen.kind is None or seen.kind == robot.kind:
        return None
    also = looks_like(seen.kind, seen.kind_why, robot, str(path))
    return RecordingError(f"{path}: its columns have names of their own. It {also}")
