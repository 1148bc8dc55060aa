"""How a table is read: as `--columns` and `--set` say, or, where nobody said it, as it looks."""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.cli.output import warn
from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.foundation.extras import needs
from deltactl.models.robot import ChainRobot, DeltaRobot, ServoAxis, StepperAxis
from deltactl.recording.tables.binary_tables import is_data_set, one_joint_at_a_time
from deltactl.recording.tables.flat import TARGET
from deltactl.recording.tables.flat_files import read_flat
from deltactl.recording.tables.foreign_log import is_log
from deltactl.recording.tables.table_format import first_cells

if TYPE_CHECKING:
    from deltactl.models.robot import RobotModel
    from deltactl.recording.foreign.mapping import Mapping
    from deltactl.recording.tables.flat import FlatRecording


ASKED = {"command", "command_1", "steps_1", "effort", "distance"}
"""Without one of these there is nothing that a reading could be compared with."""
READ = {"position", "theta_1"}
"""Without one of these there is nothing that an axis answered."""


def read_plain(
    path: Path, robot: RobotModel | None, tell: Callable[[str], None] = warn
) -> FlatRecording:
    """Read a table without a mapping: our names behind other marks, and a table that needs no
    times, are recognised and reported.

    tell: gets what was recognised. Raises RecordingError; where it looks like another machine's
    than the robot file's, saying so.
    """
    try:
        recording = read_flat(path)
    except RecordingError as error:
        wrong = error
    else:
        whole = _is_whole(recording, robot)
        return recording if whole else _as_inspected(path, robot, tell) or recording
    if is_data_set(path):
        raise one_joint_at_a_time(path)
    if is_log(path) or path.suffix in (".parquet", ".mat"):
        if (seen := _as_inspected(path, robot, tell)) is not None:
            return seen
        raise wrong
    return _read_text(path, robot, tell, wrong)


def _read_text(
    path: Path, robot: RobotModel | None, tell: Callable[[str], None], wrong: RecordingError
) -> FlatRecording:
    """Read a table of text that is none of ours as it is written; wrong: why it is none."""
    ours = "t" in first_cells(path)
    with needs("diagnosis", "tables of others"):
        from deltactl.recording.foreign.mapping import Mapping
        from deltactl.recording.foreign.reading import read_mapped
    told: list[str] = []
    try:
        mapping = Mapping()
        if not ours and _has_places(path, robot):
            mapping = Mapping(rate_hz=1.0)
            told.append(f"{path.name}: has no times, and poses at rest need none")
        recording = read_mapped(path, mapping, told.append)
        if ours and not told:
            raise wrong
    except RecordingError as error:
        if (seen := _as_inspected(path, robot, tell)) is not None:
            return seen
        from deltactl.diagnosis.admission.another_kind import without_our_names

        raise without_our_names(path, robot, wrong, None if ours else error) from None
    for line in told:
        tell(line)
    return recording


def _is_whole(recording: FlatRecording, robot: RobotModel | None) -> bool:
    """Whether it holds what was asked for, and of an axis what it answered."""
    there = recording.columns.keys()
    needed = (ASKED, READ) if isinstance(robot, ServoAxis | StepperAxis) else (ASKED,)
    return all(names & there for names in needed)


def _has_places(path: Path, robot: RobotModel | None) -> bool:
    """Whether a table has the places of targets on a chain."""
    return isinstance(robot, ChainRobot) and any(map(TARGET.fullmatch, first_cells(path)))


def _as_inspected(
    path: Path, robot: RobotModel | None, tell: Callable[[str], None]
) -> FlatRecording | None:
    """A table with names of its own, read as `--inspect` shows it; None where that leaves a number
    to be said, or is not of the robot file's kind.
    """
    from deltactl.cli.recordings.fitting import looked_at
    from deltactl.recording.foreign.mapping import joints_together
    from deltactl.recording.foreign.reading import read_mapped

    try:
        seen, why_not = looked_at(path, None, robot)
    except RecordingError:
        return None
    if not seen.options or robot is None or seen.mapping.rate_hz is not None:
        return None
    if why_not and seen.kind == robot.kind:
        raise seen.misfit(why_not, "how it can be read: {}")
    if why_not or seen.kind != robot.kind:
        return None
    if (owed := seen.owed) is not None:
        raise owed
    recording = read_mapped(path, seen.mapping)
    options = [part for one in joints_together(seen.options[1::2]) for part in ("--set", one)]
    tell(f"{path.name}: is read as inspected: {shlex.join(options)}")
    if seen.warnings:
        tell(f"{path.name}: {'; '.join(seen.warnings)}")
    return recording


def as_calibration(recording: FlatRecording, robot: RobotModel | None) -> FlatRecording:
    """A delta's encoder angles beside places of its platform, without commands, as commands: what
    the arms did is then what was asked for, and the linkage alone is judged.
    """
    arms = [f"theta_{n}" for n in (1, 2, 3)]
    there = recording.columns
    whole = {*arms, "pos_x", "pos_y", "pos_z"} <= there.keys()
    if not isinstance(robot, DeltaRobot) or not whole or {"command_1", "steps_1"} & there.keys():
        return recording
    warn(
        f"{Path(recording.source).name}: no command was recorded: the encoder angles are taken for"
        " what was asked, and the linkage is calibrated against the platform's places"
    )
    called = {arm: arm.replace("theta", "command") for arm in arms}
    columns = {called.get(name, name): values for name, values in there.items()}
    return replace(recording, columns=columns)


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
    # Not Path.is_file, which raises for a heading that is longer than a file name may be.
    return "=" not in option or os.path.isfile(option)
