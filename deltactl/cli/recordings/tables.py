"""How a table is read: as `--columns` and `--set` say, or, where nobody said it, as it looks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.cli.output import warn
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.foundation.extras import needs
from deltactl.recording.tables.flat import UNITS
from deltactl.recording.tables.flat_files import read_flat
from deltactl.recording.tables.foreign_log import is_log
from deltactl.recording.tables.lerobot import is_data_set
from deltactl.recording.tables.table_format import first_cells

if TYPE_CHECKING:
    from deltactl.models.robot import RobotModel
    from deltactl.recording.foreign.found import Inspection
    from deltactl.recording.foreign.mapping import Mapping
    from deltactl.recording.tables.flat import FlatRecording


BINARY = (".parquet", ".mat")
MOST_LISTED = 200
"""Letters of names."""


def read_plain(path: Path, robot: RobotModel | None) -> FlatRecording:
    """A recording of which nothing is said: where its heading has our names behind other marks, or
    no times are needed, that is found out and told.

    Raises RecordingError; where it looks like another machine's than the robot file's, saying so.
    """
    try:
        return read_flat(path)
    except RecordingError as error:
        wrong = error
    if is_data_set(path):
        raise RecordingError(
            f"{path}: is a LeRobot data set; one of its joints is diagnosed at a time;"
            f" which options choose it: deltactl diagnose --inspect {path}"
        )
    if is_log(path) or path.suffix in BINARY:
        raise wrong
    ours = "t" in first_cells(path)
    with needs("diagnosis", "tables of others"):
        from deltactl.recording.foreign.mapping import Mapping
        from deltactl.recording.foreign.reading import read_mapped
    told: list[str] = []
    try:
        recording = read_mapped(path, Mapping(), told.append)
        if ours and not told:
            raise wrong
    except RecordingError as error:
        if ours:
            raise _of_another_kind(path, robot) or wrong from None
        raise _with_other_names(path, robot, error) or wrong from None
    for line in told:
        warn(line)
    return recording


def _of_another_kind(path: Path, robot: RobotModel | None) -> RecordingError | None:
    """What is said of a table with times and none of our columns beside them, where it looks like
    another kind of machine than the robot file's; else None.
    """
    from deltactl.recording.foreign.inspection import inspect

    try:
        seen = inspect(path)
    except RecordingError:
        return None
    if UNITS.keys() & seen.table.keys() > {"t"} or robot is None:
        return None
    return _named_otherwise(seen, robot) if seen.kind not in (None, robot.kind) else None


def _with_other_names(
    path: Path, robot: RobotModel | None, error: RecordingError
) -> RecordingError | None:
    """What is said of a table that `error` refused: where it has names of its own, which machine
    it looks like. None where it is no table that could be looked at.
    """
    from deltactl.recording.foreign.inspection import inspect

    try:
        seen = inspect(path)
    except RecordingError:
        return None
    if UNITS.keys() & seen.table.keys():
        return error
    return _named_otherwise(seen, robot)


def _named_otherwise(seen: Inspection, robot: RobotModel | None) -> RecordingError:
    """What is said of columns with names of their own, and of the machine that they are of."""
    from deltactl.diagnosis.admission.another_kind import looks_like

    path = seen.path
    listed = ", ".join(seen.table)[:MOST_LISTED]
    names = f"its columns have names of their own ({listed})"
    own = f"{path}: {names if seen.named else 'it has no line that names its columns'}"
    if robot is None or seen.kind is None or seen.kind == robot.kind:
        return RecordingError(f"{own}; which options read them: deltactl diagnose --inspect {path}")
    also = looks_like(seen.kind, seen.kind_why, robot, str(path))
    return RecordingError(f"{path}: {also}" + (f". Its columns: {listed}" if seen.named else ""))


def mapping_of(columns: list[str]) -> Mapping:
    """Mapping files and single columns, as `--columns` and `--set` give them."""
    from deltactl.recording.foreign.mapping import load_mapping

    files = [one for one in columns if is_mapping_file(one)]
    if len(files) > 1:
        raise ConfigError(f"--columns: one mapping file at most, not {' and '.join(files)}")
    options = [one for one in columns if one not in files]
    return load_mapping(Path(files[0]) if files else None, options)


def is_mapping_file(option: str) -> bool:
    """Whether an option names a file of mappings, and not one column."""
    return "=" not in option or Path(option).is_file()
