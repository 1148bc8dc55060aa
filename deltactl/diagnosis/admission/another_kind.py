"""A table of another kind of machine than the robot file describes, or with other columns."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from deltactl.foundation.errors import MissingColumns, RecordingError
from deltactl.models.robot import DeltaRobot, RobotModel
from deltactl.recording.column_measures import first_of
from deltactl.recording.foreign.by_values import ASKED
from deltactl.recording.foreign.guess import MOTIONS, guess_columns
from deltactl.recording.foreign.guessed_units import with_units
from deltactl.recording.foreign.machine_kind import kind_of
from deltactl.recording.foreign.mapping import as_option
from deltactl.recording.foreign.names import Guess, without_unit
from deltactl.recording.tables.flat import UNITS, FlatRecording

OF_MOTORS = ("command", "theta", "steps")
"""What several motors have each, with their number."""


def of_another_kind(
    error: MissingColumns, robot: RobotModel, recording: FlatRecording
) -> MissingColumns:
    """The same error, and what to type: where the table looks like another kind of machine than
    the robot file describes, and where other columns look like those that are missing.
    """
    table = {**recording.columns, **recording.extra}
    numbers = {
        name: one
        for name, one in table.items()
        if one.dtype.kind == "f" and bool(np.isfinite(one).any())
    }
    numbers = {"t": recording.t_s, **numbers}
    guesses = {
        name: replace(guess, unit="rad") if name in recording.columns and _turns(name) else guess
        for name, guess in guess_columns(numbers, {}, named=True).items()
        if guess.name in UNITS
    }
    kind, _, why = kind_of(guesses, [])
    if kind is not None and kind != robot.kind:
        looks = looks_like(kind, why, robot, recording.source)
        missing = str(error).removeprefix(f"{recording.source}: ")
        return MissingColumns(f"{recording.source}: {looks} ({missing})", error.source)
    also = _could_be(with_units(guesses, numbers)[0], recording)
    return MissingColumns(f"{error}{also}", error.source)


def _turns(name: str) -> bool:
    """Whether a column of the program is an angle whatever the machine is."""
    return UNITS[name] == "rad"


def _could_be(guesses: Mapping[str, Guess], recording: FlatRecording) -> str:
    """Which columns with names of their own look like those of the program, and what to type."""
    wanted = MOTIONS | {"theta", "pos"} | (set() if ASKED & set(recording.columns) else {"effort"})
    found = [
        guess
        for name, guess in guesses.items()
        if name in recording.extra and guess.role in wanted and guess.name not in recording.columns
    ]
    if not found:
        return ""
    options = [
        option
        for one in found
        for option in ("--set", as_option(one.name, without_unit(one.source), one.unit or "1",
                                          None if one.scale == 1.0 else one.scale, 0.0))
    ]  # fmt: skip
    sources = ", ".join(one.source for one in found)
    names = ", ".join(one.name for one in found)
    looks = "looks" if len(found) == 1 else "look"
    return f". Here {sources} {looks} like {names}: add {shlex.join(options)}"


def looks_like(kind: str, why: str, robot: RobotModel, source: str) -> str:
    """Which kind of machine a table is of and what to type, after the table's name."""
    return (
        f"looks like a table of a {kind} ({why}), and the robot file describes a"
        f" {robot.kind}. To look at it, type: deltactl diagnose {shlex.quote(source)}"
        f" --inspect; to describe such a machine: deltactl init my-{kind.replace('_', '-')}.yaml"
        f" --kind {kind}"
    )


def refuse_several_motors(robot: RobotModel, recording: FlatRecording) -> None:
    """Refuse motors beside the first where the robot file knows one axis. Raises RecordingError.

    Columns without a number, which somebody chose, are those of the axis.
    """
    named = "position" in recording.columns and {"command", "effort"} & set(recording.columns)
    if isinstance(robot, DeltaRobot) or named:
        return
    others = [f"{stem}_{motor}" for stem in OF_MOTORS for motor in (2, 3)]
    there = [name for name in others if first_of(recording, [name])]
    if there:
        also = looks_like("delta", f"it has {', '.join(there)}", robot, recording.source)
        raise RecordingError(
            f"{recording.source}: {also}. To diagnose one of its motors alone, choose the"
            " columns: --set command=COLUMN[unit] --set position=COLUMN[unit]"
        )
