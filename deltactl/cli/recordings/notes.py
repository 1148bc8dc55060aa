"""What is said beside an answer: columns without use, where an effort is, what to type next."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.cli.output import warn
from deltactl.cli.recordings.tables import is_mapping_file, mapping_of
from deltactl.foundation.errors import DeltactlError
from deltactl.foundation.printable import count
from deltactl.models.robot import DeltaRobot, RobotModel, ServoAxis

if TYPE_CHECKING:
    from deltactl.diagnosis.answer.records import Diagnosis
    from deltactl.diagnosis.report.templates import Ways
    from deltactl.recording.tables.flat import FlatRecording


FILES_NAMED = 2
"""Files that a remark names; the rest are counted."""


class Notes:
    """What of recordings this robot file leaves without use, noted while they are read."""

    def __init__(self, robot: RobotModel, columns: Sequence[str]):
        """columns: as --columns and --set say them."""
        self._robot, self._columns = robot, list(columns)
        self._remarks: dict[str, list[str]] = {}
        """Each remark with the files that it is about."""
        self.columns_used: dict[str, None] = {}
        """As the report names them, in the order in which they were read."""
        self._command_unused: dict[str, str] = {}
        self._effort_read = False

    def around(self, read: Callable[[Path], FlatRecording]) -> Callable[[Path], FlatRecording]:
        """The same reading, which also says where an effort is left without use."""
        from deltactl.diagnosis.admission.doubts import far_for_a_joint
        from deltactl.recording.column_measures import first_of

        def noted(path: Path) -> FlatRecording:
            recording = read(path)
            command, effort = self._source("command"), self._source("effort")
            if why := effort_unused(self._robot, recording, effort) or self._twice():
                self.warn(why, path.name)
            sources = mapping_of(self._columns).columns
            for name in ("t", *recording.columns):
                own = sources[name].from_ if name in sources else None
                shown = f"{name} from '{own}'" if own and own != name else name
                self.columns_used.setdefault(shown)
            self._effort_read |= first_of(recording, ["effort"]) is not None
            if not self._columns and far_for_a_joint(self._robot, recording) is not None:
                self._propose(path)
            if why := command_unused(recording, (command, effort)):
                self._command_unused[path.name] = why
            return recording

        return noted

    def warn(self, text: str, file: str = "") -> None:
        """Note a remark on what was read; of several files once."""
        files = self._remarks.setdefault(text, [])
        if file and file not in files:
            files.append(file)

    @property
    def remarks(self) -> list[str]:
        """One line each, with the files that it is of."""
        return [f"{_of(files)}{text}" for text, files in self._remarks.items()]

    def print_remarks(self, most: int) -> list[str]:
        """Print them beside the answer, which then has the fewer lines; returns those lines.

        most: remarks that are shown; the rest are counted, and are in the report.
        """
        lines = self.remarks[:most]
        if more := len(self.remarks) - most if len(self.remarks) > most else 0:
            lines.append(f"{count(more, 'more remark')} on what was read: see --report FILE.html")
        for line in lines:
            warn(line)
        return lines

    def _propose(self, path: Path) -> None:
        """Note the units that inspection proposes for columns beyond what a joint turns."""
        from deltactl.recording.foreign.inspection import inspect

        try:
            robot = self._robot
            seen = inspect(path, motion=robot.motion if isinstance(robot, ServoAxis) else None)
        except DeltactlError:
            return
        if seen.options and not seen.own_run:
            why = "; ".join(seen.warnings)
            options = shlex.join(seen.options)
            self.warn(f"inspect proposes {options}{f' ({why})' if why else ''}", path.name)

    def _source(self, name: str) -> str | None:
        """What a column is called in the file, where it was given."""
        source = mapping_of(self._columns).columns.get(name)
        return source.from_ if source else None

    def _twice(self) -> str:
        """That a column of forces is multiplied as if it were one of currents; else empty."""
        from deltactl.recording.foreign.names import read_name
        from deltactl.recording.foreign.units import PULLING

        source = mapping_of(self._columns).columns.get("effort")
        gain = self._robot.force_per_effort if isinstance(self._robot, ServoAxis) else 1.0
        if source is None or source.from_ is None or gain == 1.0:
            return ""
        unit = source.unit if source.unit != "1" else read_name(source.from_).unit
        if unit not in PULLING:
            return ""
        what = "force" if unit in ("N", "mN") else "torque"
        return (
            f"effort: '{source.from_}' is in {unit} already and is multiplied by the robot file's"
            f" effort_gain ({gain:g}) all the same; where it is a {what} at the axis, set"
            " effort_gain to 1"
        )

    def say_of(self, answer: Diagnosis) -> None:
        """That the commands were not used, of an axis that was judged by its forces, and in which
        unit these are where the robot file does not say it.
        """
        if isinstance(self._robot, ServoAxis) and answer.fit.unit in ("N", "N m"):
            if self._robot.effort_gain == "unknown":
                self.warn(in_unit_of_effort(self._source("effort") or "effort", answer.fit.unit))
            for name, why in self._command_unused.items():
                self.warn(why, name)

    def ways(self, answer: Diagnosis, recordings: Sequence[Path]) -> Ways:
        """The words for what to do, where an effort would tell more: which one, and what to type.

        The first recording is looked at again only where an effort would tell anything apart.
        """
        from deltactl.diagnosis.report.next_run import asks_for_effort
        from deltactl.diagnosis.report.templates import TERMINAL

        if not asks_for_effort(answer.findings):
            return TERMINAL
        if not isinstance(self._robot, ServoAxis):
            return replace(TERMINAL, or_effort="")
        lacks = self._robot.inertia is None
        mass = "`inertia` (what moves, in kg m2, or kg of a slide) and `effort_gain`"
        if self._effort_read:
            there = f", or enter {mass} in the robot file: then the effort that was read is used"
            return replace(TERMINAL, or_effort=there)
        column = self._effort_in(recordings[0])
        if column is None:
            return TERMINAL
        option = shlex.join(["--set", f"effort={column}"])
        more = f", with {mass} in the robot file" if lacks else ""
        return replace(TERMINAL, or_effort=f", or have the effort read as well: {option}{more}")

    def _effort_in(self, path: Path) -> str | None:
        """The column that inspection takes for an effort; None where there is none."""
        from deltactl.recording.foreign.inspection import inspect
        from deltactl.recording.foreign.names import without_unit

        try:
            guesses = inspect(path, mapping_of(self._columns)).guesses
        except DeltactlError:
            return None
        found = (without_unit(name) for name, guess in guesses.items() if guess.name == "effort")
        return next(found, None)


def _of(files: Sequence[str]) -> str:
    """The files that a remark is of, before it."""
    shown, more = list(files[:FILES_NAMED]), len(files) - FILES_NAMED
    named = ", ".join([*shown, f"{more} more"] if more > 0 else shown)
    return f"{named}: " if named else ""


def effort_unused(robot: RobotModel, recording: FlatRecording, column: str | None) -> str:
    """Why the effort beside a command is not used, and what it may be instead; empty where it is
    used, or there is none. column: its name in the file, where it has another one.
    """
    from deltactl.recording.column_measures import first_of

    if not isinstance(robot, ServoAxis) or robot.inertia is not None:
        return ""
    if first_of(recording, ["effort"]) is None or first_of(recording, ["command"]) is None:
        return ""
    return (
        "effort is not used, as the robot file has no `inertia`: what the drive gives says nothing"
        " without it. If it pulls at the axis from outside (a weight, a spring), read it as load:"
        f" --set load={column or 'effort'}"
    )


def in_unit_of_effort(column: str, unit: str) -> str:
    """What forces are in where the size of a unit of the effort is unknown."""
    return (
        f"effort_gain is unknown: read every {unit} below as the unit of '{column}'. Enter as"
        f" effort_gain how many {unit} one of it makes, and diagnose again"
    )


def command_unused(recording: FlatRecording, columns: tuple[str | None, str | None]) -> str:
    """That the command beside an effort is not used, of a diagnosis of forces, and how to get the
    other one; empty where there is none. columns: names of command and effort in the file.
    """
    from deltactl.recording.column_measures import first_of

    if first_of(recording, ["command"]) is None:
        return ""
    command, effort = columns
    told = f" ({command})" if command else ""
    leave_out = f"leave out --set effort={effort}" if effort else "add --set effort="
    return (
        f"the command{told} is not used: with `inertia` in the robot file and an effort, forces are"
        " compared (friction, mass). To compare the position with its command instead (delay,"
        f" play, backlash), {leave_out}"
    )


def next_commands(
    recordings: Sequence[Path], saved: Path, columns: Sequence[str], robot: RobotModel
) -> list[str]:
    """What to type after a robot file was saved: the same recordings against it, and a run."""
    options = [
        part
        for option in columns
        for part in ("--columns" if is_mapping_file(option) else "--set", option)
    ]
    again = ["deltactl", "diagnose", *map(str, recordings), "--robot", str(saved), *options]
    lines = [f"check it:   {shlex.join(again)}"]
    if isinstance(robot, DeltaRobot):
        lines.append(
            f"run a job:  {shlex.join(['deltactl', 'run', 'JOB.yaml', '--robot', str(saved)])}"
        )
    return lines
