"""A table that was looked at, read for a machine that is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.printable import count
from deltactl.recording.foreign.found import Inspection
from deltactl.recording.foreign.names import BY_NAME, Guess, of_role
from deltactl.recording.tables.chain_tables import columns_of
from deltactl.recording.tables.flat import TARGET

EFFORT = "effort"


def without_effort(seen: Inspection) -> Inspection:
    """The same table, of which no column is read as an effort."""
    columns = {name: one for name, one in seen.mapping.columns.items() if name != EFFORT}
    mapping = seen.mapping.model_copy(update={"columns": columns})
    efforts = [f"{name}: " for name, guess in seen.guesses.items() if guess.name == EFFORT]
    warnings = [one for one in seen.warnings if not one.startswith(tuple(efforts))]
    return replace(seen, mapping=mapping, warnings=warnings)


def effort_option(seen: Inspection) -> str:
    """What `--set` takes to read the effort as well; empty where the table calls it so itself."""
    return next((one for one in seen.options if one.startswith(f"{EFFORT}=")), "")


def as_chain(seen: Inspection, joints: Sequence[str]) -> Inspection | None:
    """The table as that of a chain with these joints; None where it lacks one of their columns.

    A chain reads its columns by their own names: by the place of the joint, or its name.
    """
    guesses = {
        name: Guess(name, stem, str(number), None, BY_NAME)
        for stem in ("theta", "command", "velocity", EFFORT)
        for number, (_, others) in enumerate(columns_of(joints, stem), 1)
        if (name := next((one for one in others if one in seen.table), None)) is not None
    }
    of_all = {
        role for role in ("theta", "command", EFFORT) if len(of_role(guesses, role)) == len(joints)
    }
    placed = any(map(TARGET.fullmatch, seen.table)) and not of_all.isdisjoint(("theta", "command"))
    if not (placed or of_all >= {"theta", EFFORT}):
        return None
    times = {name: seen.guesses[name] for name in of_role(seen.guesses, "t")}
    columns = {name: one for name, one in seen.mapping.columns.items() if name == "t"}
    asked = f"{'efforts' if EFFORT in of_all else 'places of a target'} and angles"
    return replace(
        seen,
        guesses=times | guesses,
        kind="chain",
        motion=None,
        kind_why=f"{asked} of {count(len(joints), 'joint')}",
        mapping=seen.mapping.model_copy(update={"columns": columns}),
        warnings=[],
        asked=None,
    )


def misfit(path: Path, why: str) -> RecordingError:
    """The error of a table that is not the recording of a machine."""
    return RecordingError(f"{path}: {why}")
