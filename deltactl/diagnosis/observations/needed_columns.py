"""Columns of single axes and lone sensors: which are needed, which stand in, and are they sane."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.foundation.errors import MissingColumns, RecordingError
from deltactl.models.effects.lone_axis import said
from deltactl.models.robot import RobotModel, ServoAxis
from deltactl.recording.column_measures import first_of, travel
from deltactl.recording.tables.flat import FlatRecording

STANDS_IN = {
    "command_1": "command_1 [rad] or steps_1 [microsteps] with `drive` in the robot file",
    "theta_1": "theta_1 [rad], the angle measured at the output (position [rad] is taken too)",
    "position": "position [rad or m], the measured position (theta_1 [rad] is taken too)",
    "command": "command [rad or m], or effort with `inertia` in the robot file",
    "effort": "effort, or command [rad or m]",
    "distance": "distance [m], the true distance",
    "range": "range [m], what the sensor reported",
}
MAPPING = "give other names and units with --set name=column[unit]; --inspect says how"


def needed(recording: FlatRecording, names: Sequence[str], wanted: str) -> str:
    """The same; raises MissingColumns naming what is missing and what could stand for it."""
    name = first_of(recording, names)
    if name is None:
        raise MissingColumns(
            f"{recording.source}: column {wanted} missing or empty; it needs {STANDS_IN[wanted]}; "
            f"it has t, {', '.join([*recording.columns, *recording.extra])}; {MAPPING}",
            recording.source,
        )
    return name


def effort_unused(robot: RobotModel, recording: FlatRecording, column: str | None) -> str:
    """Why the effort beside a command is not used, and what it may be instead; empty where it is
    used, or there is none. column: its name in the file, where it has another one.
    """
    if not isinstance(robot, ServoAxis) or robot.inertia is not None:
        return ""
    if first_of(recording, ["effort"]) is None or first_of(recording, ["command"]) is None:
        return ""
    return (
        "effort is not used, as the robot file has no `inertia`: what the drive gives says nothing"
        " without it. If it pulls at the axis from outside (a weight, a spring), read it as load:"
        f" --set load={column or 'effort'}"
    )


def command_unused(recording: FlatRecording, columns: tuple[str | None, str | None]) -> str:
    """That the command beside an effort is not used, of a diagnosis of forces, and how to get the
    other one; empty where there is none. columns: names of command and effort in the file.
    """
    if first_of(recording, ["command"]) is None:
        return ""
    command, effort = columns
    told = f" ({command})" if command else ""
    leave_out = f"--set effort={effort}" if effort else "the column `effort`"
    return (
        f"the command{told} is not used: with `inertia` in the robot file and an effort, forces are"
        " compared (friction, mass). To compare the position with its command instead (delay,"
        f" play, backlash), leave out {leave_out}"
    )


def filled(recording: FlatRecording, name: str) -> FloatArray:
    """An input column with short holes bridged; RecordingError when it is mostly empty."""
    values = recording.columns[name]
    known = np.isfinite(values)
    if known.mean() < OBSERVATIONS.least_known:
        raise RecordingError(f"{recording.source}: {name} is empty in more than half of the rows")
    bridged: FloatArray = np.interp(recording.t_s, recording.t_s[known], values[known])
    return bridged


def refuse_still(values: FloatArray, name: str, source: str) -> None:
    """Nothing can be told from a machine that was not moved."""
    spread = float(np.nanmax(values) - np.nanmin(values))
    if not spread > 1e-12 * max(1.0, float(np.nanmax(np.abs(values)))):
        raise RecordingError(f"{source}: {name} never changes; nothing can be told from it")


def refuse_other_units(
    asked: FloatArray, seen: FloatArray, names: tuple[str, str], unit: str, source: str
) -> None:
    """Motions that differ by a factor of fifty and more are units, not physics.

    names: of what was seen and asked, both in `unit`.
    """
    wide, told = travel(asked), travel(seen)
    if wide <= 0.0 or told <= 0.0:
        return
    ratio = max(told, wide) / min(told, wide)
    if ratio > OBSERVATIONS.largest_ratio:
        raise RecordingError(
            f"{source}: {names[0]} moves by {said(told, unit)} and {names[1]} by"
            f" {said(wide, unit)}, a ratio of {ratio:.3g};"
            " are the units (rad, m, microsteps) or the robot file another machine's?"
        )
