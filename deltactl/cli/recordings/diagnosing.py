"""What `deltactl diagnose` does with one robot's recordings."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.cli.file_arguments import refuse_missing
from deltactl.cli.output import (
    lines_of,
    print_json,
    print_wrapped,
    say,
    screen_width,
    waiting,
    warn,
)
from deltactl.cli.recordings.notes import Notes, next_commands
from deltactl.cli.recordings.tables import as_calibration, mapping_of, read_plain
from deltactl.firmware_py.named_files import CONFIG_FOLDER, ROBOT_KEY, find
from deltactl.foundation.errors import ConfigError, DeltactlError
from deltactl.foundation.extras import needs
from deltactl.foundation.one_screen import LINES, Part
from deltactl.foundation.printable import count
from deltactl.models.robot import ChainRobot, DeltaRobot, RobotModel, ServoAxis
from deltactl.models.robot_files import load_with_effects

if TYPE_CHECKING:
    from deltactl.diagnosis.answer.records import Diagnosis
    from deltactl.diagnosis.report.templates import Ways
    from deltactl.recording.tables.flat import FlatRecording

FEWEST_LINES = 12
"""Lines of an answer beside what else was asked for."""
OF_ONE_AXIS = ("position", "command", "velocity", "effort")
"""Columns that several joints have each, with a number."""
MOST_REMARKS = 2
"""Remarks on what was read that are shown beside an answer."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is written of an answer, and where."""

    json_file: Path | None = None
    """`-` is the terminal, on which nothing else is then printed."""
    report: Path | None = None
    save_robot: Path | None = None
    save_all: bool = False
    """Also findings that are improbable or not certain."""
    next_job: Path | None = None
    force: bool = False

    @property
    def quiet(self) -> bool:
        """Whether the terminal gets JSON alone."""
        return str(self.json_file) == "-"


def diagnose_recordings(
    recordings: list[Path],
    robot: str,
    holdout: list[Path],
    columns: list[str],
    wanted: Wanted,
) -> None:
    """Diagnose, print the findings in plain sentences, and write the files asked for."""
    quiet, save_robot, next_job = wanted.quiet, wanted.save_robot, wanted.next_job
    json_file, report, save_all = wanted.json_file, wanted.report, wanted.save_all
    with waiting("loading", quiet), needs("diagnosis", "diagnose"):
        from deltactl.diagnosis.answer.corrected_robot import save_corrected
        from deltactl.diagnosis.api import diagnose
        from deltactl.diagnosis.experiment import write_job
        from deltactl.diagnosis.report.next_run import written as what_is_written
        from deltactl.diagnosis.report.page import Origin, write_report

    robot_file = find(robot, key=ROBOT_KEY)
    refuse_missing([*recordings, *holdout])
    described = load_with_effects(robot_file)
    if columns:
        _refuse_other_motion(columns, described)
        _refuse_of_one_axis(columns, described)
    notes = Notes(described, columns)
    read = notes.around(read_with(columns, described, notes.warn))
    with waiting("reading", quiet) as show:
        written = None if quiet else json_file
        try:
            answer = diagnose(recordings, robot_file, holdout, written, show, read)
        except DeltactlError:
            notes.print_remarks(MOST_REMARKS)
            raise
    notes.say_of(answer)
    remarks = notes.print_remarks(MOST_REMARKS)
    ways = notes.ways(answer, recordings)
    if next_job is not None and answer.next_experiment is not None:
        write_job(answer.next_experiment, next_job, robot_file, CONFIG_FOLDER)
    if save_robot is not None:
        ways = replace(ways, save="")
        save_corrected(robot_file, answer, save_robot, save_all, replace=wanted.force)
    if report is not None:
        command = shlex.join(["deltactl", *sys.argv[1:]])
        origin = Origin(str(robot_file), [*notes.columns_used], command, notes.remarks)
        with waiting("writing the report", quiet):
            write_report(answer, described, report, ways, origin)
        ways = replace(ways, rest=ways.rest.replace("--report FILE.html", "in the report"))
    if quiet:
        print_json(answer.to_json())
        return
    files = {"report": report, "answer": json_file}
    after = [f"{name}: {path}" for name, path in files.items() if path is not None]
    if next_job is not None:
        after.append(f"job: {_job(answer, described, next_job)}")
    if save_robot is not None:
        after.append(f"robot file: {save_robot}, {what_is_written(answer, save_all)}")
        if save_robot.read_bytes() != robot_file.read_bytes():
            after += next_commands(recordings, save_robot, columns, described)
    saved = None if save_robot is None else save_all
    print_answer(Shown(answer, described, ways, saved=saved), after, remarks)


@dataclass(frozen=True, slots=True)
class Shown:
    """What a screen shows: see `report.screen.screen_lines`."""

    answer: Diagnosis
    robot: RobotModel
    ways: Ways | None = None
    done: Part | None = None
    closing: Sequence[Part] = ()
    saved: bool | None = None


def print_answer(shown: Shown, after: Sequence[str], before: Sequence[str] = ()) -> None:
    """Print an answer on one screen, with what was printed before it and comes after it.

    after: lines that are not broken, so that a file or a command in them can be copied.
    """
    from deltactl.diagnosis.report.screen import marked, screen_lines
    from deltactl.diagnosis.report.templates import TERMINAL

    width = screen_width()
    room = max(LINES - lines_of((*before, *after), width), FEWEST_LINES), width
    ways = shown.ways or TERMINAL
    lines = screen_lines(
        shown.answer, shown.robot, ways, room, shown.done, shown.closing, shown.saved
    )
    print_wrapped(marked(lines))
    for line in after:
        say(line)


def _job(answer: Diagnosis, robot: RobotModel, path: Path) -> str:
    """Where the job is, or why there is none."""
    if answer.next_experiment is not None:
        return str(path)
    designed = isinstance(robot, DeltaRobot | ChainRobot)
    why = "no run would tell more" if designed else "only deltas and chains have jobs"
    return f"none, as {why}"


def _refuse_other_motion(columns: list[str], robot: RobotModel) -> None:
    """Raise ConfigError where a length was said of an axis that turns, or an angle of a slide."""
    from deltactl.recording.foreign.doubts import other_motion

    mapping = mapping_of(columns)
    units = {name: column.unit for name, column in mapping.columns.items()}
    units |= {"position": mapping.unit} if mapping.unit else {}
    if isinstance(robot, ServoAxis) and (why := other_motion(units, robot.motion)):
        raise ConfigError(f"--set: {why}")


def _refuse_of_one_axis(columns: list[str], robot: RobotModel) -> None:
    """Raise ConfigError where a column was said that only a single axis has."""
    named = [name for name in mapping_of(columns).columns if name in OF_ONE_AXIS]
    if named and isinstance(robot, ChainRobot):
        raise ConfigError(
            f"--set {named[0]}: the robot file describes {count(len(robot.joints), 'joint')},"
            f" whose columns are theta_1, effort_1 and so on, or called by the joint"
            f" (theta_{robot.joints[0]}), in rad and m; leave out --set {named[0]}, and rename the"
            " columns where the table has other names"
        )


def read_with(
    columns: list[str],
    robot: RobotModel | None = None,
    tell: Callable[[str], None] = warn,
) -> Callable[[Path], FlatRecording]:
    """What reads recordings, with the mapping that these options say.

    robot: the machine that they are said to be of. tell: gets remarks on their columns.
    """
    if not columns:
        return lambda path: as_calibration(read_plain(path, robot, tell), robot)
    with needs("diagnosis", "--set"):
        from deltactl.recording.foreign.reading import read_mapped
    mapping = mapping_of(columns)
    return lambda path: as_calibration(read_mapped(path, mapping, tell), robot)
