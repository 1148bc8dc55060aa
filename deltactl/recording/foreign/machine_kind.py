"""Which kind of machine a table is of, by the columns that were recognised."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence

import numpy as np

from deltactl.recording.foreign.names import Guess, pulls, read_name, without_unit
from deltactl.recording.foreign.options import GUESSES
from deltactl.recording.foreign.units import LINEAR, ROTARY
from deltactl.recording.reading.columns import FloatArray

COMMANDED = ("command", "position")


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
