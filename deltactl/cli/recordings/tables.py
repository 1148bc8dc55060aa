"""How a table is read: as `--columns` and `--set` say, or, where nobody said it, as it looks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.cli.output import warn
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.foundation.extras import needs
from deltactl.recording.tables.binary_tables import is_data_set, one_joint_at_a_time
from deltactl.recording.tables.flat_files import read_flat
from deltactl.recording.tables.foreign_log import is_log
from deltactl.recording.tables.table_format import first_cells

if TYPE_CHECKING:
    from deltactl.models.robot import RobotModel
    from deltactl.recording.foreign.mapping import Mapping
    from deltactl.recording.tables.flat import FlatRecording


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
    if is_data_set(path):
        raise one_joint_at_a_time(path)
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
        from deltactl.diagnosis.admission.another_kind import without_our_names

        raise without_our_names(path, robot, wrong, None if ours else error) from None
    for line in told:
        warn(line)
    return recording


def mapping_of(columns: list[str]) -> Mapping:
    """Mapping files and single columns, as `--columns` and `--set` give them."""
    from deltactl.recording.foreign.mapping import load_mapping

    files = [option for option in columns if is_mapping_file(option)]
    if len(files) > 1:
        raise ConfigError(f"--columns: one mapping file at most, not {' and '.join(files)}")
    options = [option for option in columns if option not in files]
    return load_mapping(Path(files[0]) if files else None, options)


def is_mapping_file(option: str) -> bool:
    """Whether an option names a file of mappings, and not one column."""
    return "=" not in option or Path(option).is_file()
