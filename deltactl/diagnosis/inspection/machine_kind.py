"""Which kind of machine a table is of, by the columns that were recognised."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from deltactl.diagnosis.columns.mapping import as_option
from deltactl.diagnosis.columns.names import Guess, pulls, read_name, without_unit
from deltactl.diagnosis.columns.options import GUESSES
from deltactl.diagnosis.columns.units import LINEAR, ROTARY
from deltactl.diagnosis.inspection.by_values import ASKED
from deltactl.diagnosis.inspection.guess import MOTIONS, guess_columns
from deltactl.diagnosis.inspection.units import with_units
from deltactl.diagnosis.observations.needed_columns import first_of
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.foundation.errors import MissingColumns, RecordingError
from deltactl.models.robot import DeltaRobot, RobotModel
from deltactl.recording.tables.flat import UNITS, FlatRecording

COMMANDED = ("command", "position")
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


def kind_of(
    guesses: Mapping[str, Guess], left: Sequence[str]
) -> tuple[str | None, str | None, str]:
    """Kind of machine, linear or rotary, and why; `left`: columns that nothing is known of."""
    there = {guess.name for guess in guesses.values()}
    units = {
        guess.unit for guess in guesses.values() if guess.role in ("command", "position", "theta")
    }
    motion = "rotary" if units & set(ROTARY) else "linear" if units & set(LINEAR) else None
    if there >= {"steps_2", "steps_3"} or there >= {"command_2", "command_3"}:
        return "delta", None, "commands of three motors"
    if "steps_1" in there and {"theta_1", "position"} & there:
        return "stepper_axis", None, "a count of steps, and the angle that came of it"
    if "range" in there and not {"command", "effort"} & there:
        return "range_sensor", None, "distances, true and reported"
    if {"position", "theta_1"} & there and {"command", "effort"} & there:
        asked = " and ".join(sorted({"command", "effort"} & there))
        return "servo_axis", motion, f"{asked} in, position out"
    return None, motion, f"not enough is known: {_lacking(guesses, left)}"


def _lacking(guesses: Mapping[str, Guess], left: Sequence[str]) -> str:
    """What is needed besides, and how it is said; `left`: columns that nothing is known of."""
    here = "here too: --inspect"
    position = next((one.source for one in guesses.values() if one.name == "position"), None)
    if position is None:
        likely = next((one for one in left if not pulls(one)), None)
        example = shlex.join(["--set", f"position={without_unit(likely or 'COLUMN')}"])
        return f"a position or a reading was not found; say which column it is, {here} {example}"
    twin = next((one for one in left if read_name(one).unit in (*LINEAR, *ROTARY)), None)
    if twin is not None:
        names = [without_unit(one) for one in (position, twin)]
        asked, read = (f"{role}={one}" for role, one in zip(COMMANDED, names, strict=True))
        return (
            f"{' and '.join(names)} both look like positions; say which was commanded and which was"
            f" read, {here} {shlex.join(['--set', asked, '--set', read])}"
        )
    likely = next((one for one in left if pulls(one)), left[0] if left else "COLUMN")
    name = without_unit(likely)
    example = shlex.join(["--set", f"effort={name}"])
    counts = "" if pulls(likely) else f"; or, if it counts steps, {_set('steps_1', name)}"
    return f"a command or an effort was not found; say which column it is, {here} {example}{counts}"


def _set(name: str, column: str) -> str:
    return shlex.join(["--set", f"{name}={column}"])


def zero_of(guesses: Mapping[str, Guess], table: Mapping[str, FloatArray]) -> str | None:
    """Whether command and reading of an axis share their zero."""
    by_name = {guess.name: guess for guess in guesses.values()}
    for asked, seen in (("command", "position"), ("command_1", "theta_1")):
        if asked not in by_name or seen not in by_name:
            continue
        one, other = by_name[asked], by_name[seen]
        if one.unit != other.unit:
            return None
        values = table[one.source]
        apart = abs(float(np.nanmedian(table[other.source] - values)))
        width = float(np.nanmax(values) - np.nanmin(values))
        return "arbitrary" if apart > GUESSES.zeros_apart * width else "absolute"
    return None
