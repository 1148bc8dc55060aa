"""A table of another kind of machine than the robot file describes, or with names of its own."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Set
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.diagnosis.admission.refusal import Refusal, refusal, refuse
from deltactl.foundation.errors import RecordingError, RefusedRecording
from deltactl.models.robot import ChainRobot, DeltaRobot, RobotModel
from deltactl.recording.column_measures import first_of
from deltactl.recording.foreign.by_values import ASKED
from deltactl.recording.foreign.found import Inspection, init_words, robot_named_after
from deltactl.recording.foreign.guess import MOTIONS, guess_columns
from deltactl.recording.foreign.guessed_units import with_units
from deltactl.recording.foreign.inspection import inspect
from deltactl.recording.foreign.kinds import kind_of
from deltactl.recording.foreign.mapping import as_option
from deltactl.recording.foreign.missing import listed
from deltactl.recording.foreign.names import Guess, without_unit
from deltactl.recording.tables.chain_tables import joint_columns
from deltactl.recording.tables.flat import UNITS, FlatRecording

OF_MOTORS = ("command", "theta", "steps")
"""What several motors have each, with their number."""


def of_another_kind(found: Refusal, robot: RobotModel, recording: FlatRecording) -> Refusal:
    """The refusal of a recording without the columns that it needs, and what to type: where the
    table looks like another kind of machine than the robot file describes, and where other columns
    look like those that are missing.
    """
    table = {"t": recording.t_s, **recording.columns, **recording.extra}
    numbers = {
        name: values
        for name, values in table.items()
        if values.dtype.kind == "f" and bool(np.isfinite(values).any())
    }
    guesses = {
        name: replace(guess, unit="rad") if UNITS.get(name) == "rad" else guess
        for name, guess in guess_columns(numbers, {}, named=True).items()
        if guess.name in UNITS
    }
    kind, _, why = kind_of(guesses, [])
    of_it = isinstance(robot, ChainRobot) and all(joint_columns(robot.joints, recording, "theta"))
    if kind is not None and kind != robot.kind and not of_it:
        also = f" ({found.why}{found.between}{found.remedy})"
        looks = _looks_like(kind, why, robot, recording.source)
        return refusal("another_kind", recording.source, found.column, also=also, **looks)
    wanted = {"effort"} if of_it else MOTIONS | {"theta", "pos", "effort"}
    more = _could_be(with_units(guesses, numbers)[0], recording, wanted)
    return replace(found, remedy=f"{found.remedy}{more}")


def _could_be(guesses: Mapping[str, Guess], recording: FlatRecording, wanted: Set[str]) -> str:
    """Which columns with names of their own look like those of the program, and what to type."""
    wanted = wanted - ({"effort"} if ASKED & set(recording.columns) else set())
    found = [
        guess
        for name, guess in guesses.items()
        if name in recording.extra and guess.role in wanted and guess.name not in recording.columns
    ]
    if not found:
        return ""
    options = [option for guess in found for option in ("--set", _option(guess))]
    sources = ", ".join(guess.source for guess in found)
    names = ", ".join(guess.name for guess in found)
    looks = "looks" if len(found) == 1 else "look"
    return f". Here {sources} {looks} like {names}: add {shlex.join(options)}"


def _option(guess: Guess) -> str:
    scale = None if guess.scale == 1.0 else guess.scale
    return as_option(guess.name, without_unit(guess.source), guess.unit or "1", scale, 0.0)


def _looks_like(kind: str, why: str, robot: RobotModel, source: str) -> dict[str, Any]:
    """Which kind of machine a table is of and what to type."""
    file = f"{robot_named_after(Path(source))}.yaml"
    init = shlex.join(["deltactl", *init_words(kind, file)])
    known, quoted = robot.kind, shlex.quote(source)
    return {"kind_seen": kind, "seen": why, "kind_known": known, "quoted": quoted, "init": init}


def refuse_several_motors(robot: RobotModel, recording: FlatRecording) -> None:
    """Refuse motors beside the first where the robot file knows one axis. Raises RefusedRecording.

    Columns without a number, which somebody chose, are those of the axis.
    """
    named = "position" in recording.columns and {"command", "effort"} & set(recording.columns)
    if isinstance(robot, DeltaRobot | ChainRobot) or named:
        return
    others = [f"{stem}_{motor}" for stem in OF_MOTORS for motor in (2, 3)]
    there = [name for name in others if first_of(recording, [name])]
    if there:
        looks = _looks_like("delta", f"it has {', '.join(there)}", robot, recording.source)
        refuse("several_motors", recording.source, there[0], **looks)


def without_our_names(
    path: Path, robot: RobotModel | None, wrong: RecordingError, otherwise: RecordingError | None
) -> RecordingError:
    """What is said of a table that could not be read with the program's own names.

    wrong: why not. otherwise: of one without even our times, why it cannot be read by what its
    columns look like. Where it looks like another machine's than the robot file's, or has names of
    its own, that is said instead.
    """
    try:
        seen = inspect(path)
    except RecordingError:
        return wrong
    ours = UNITS.keys() & seen.table.keys()
    if otherwise is not None:
        return otherwise if ours else _named_otherwise(seen, robot)
    if ours > {"t"} or robot is None or seen.kind in (None, robot.kind):
        return wrong
    return _named_otherwise(seen, robot)


def _named_otherwise(seen: Inspection, robot: RobotModel | None) -> RefusedRecording:
    """What is said of columns with names of their own, and of the machine that they are of."""
    source, names = str(seen.path), listed(seen.table)
    if robot is None or seen.kind is None or seen.kind == robot.kind:
        known = {one.role for one in seen.guesses.values()}
        case = "own_names" if seen.named else "no_names"
        if seen.kind is None and known and not (MOTIONS | {"theta", "pos", "effort"}) & known:
            case = "no_motion_by_names"
        return refusal(case, source, listed=names).error()
    also = f". Its columns: {names}" if seen.named else "."
    looks = _looks_like(seen.kind, seen.kind_why, robot, source)
    return refusal("another_kind", source, also=also, **looks).error()
