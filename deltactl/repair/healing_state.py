"""The state of a healing as a file: what is done, and what brings the old robot file back.

The robot file itself is replaced in one moment, by a rename, after all else is written down here.
Killed at any other moment, the file that was in force is in force.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import said_of_output, write_whole

STATE, BEFORE = "healing.json", "before.yaml"
SURVEY, EXPERIMENT, OLD, NEW = "survey", "experiment", "before", "after"
"""Kinds of recordings."""


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Recorded(_Record):
    """A finished recording. seconds: how long the robot took for it."""

    kind: str
    file: Path
    seconds: float


class Exchange(_Record):
    """One robot file in place of another, by their digests; the old text is in the folder."""

    old_sha256: str
    new_sha256: str


class Healing(_Record):
    """All that a killed healing needs to go on, and a finished one to be undone."""

    robot_file: Path
    job: Path
    old_sha256: str
    step: str = ""
    recordings: tuple[Recorded, ...] = ()
    exchange: Exchange | None = None
    """Written before the robot file is replaced: whether it was is seen in the file."""
    kept: dict[str, Any] | None = None
    """The answer of a correction that is kept, written before the robot file is replaced."""
    answer: dict[str, Any] | None = None
    """What came of it; None until it has ended."""

    def of(self, *kinds: str) -> list[Recorded]:
        """Recordings of these kinds, in order."""
        return [one for one in self.recordings if one.kind in kinds]

    @property
    def is_exchanged(self) -> bool:
        """Whether this healing has replaced the robot file; an earlier one may have, too."""
        made = self.exchange
        if made is None or made.old_sha256 != self.old_sha256:
            return False
        return digest_of(self.robot_file) == made.new_sha256

    @property
    def robot_s(self) -> float:
        """How long the robot moved in all [s]."""
        return sum(one.seconds for one in self.recordings)


def read_healing(folder: Path) -> Healing | None:
    """The healing in a folder; None where there is none. Raises ConfigError for a broken one."""
    path = folder / STATE
    if not path.exists():
        return None
    try:
        return Healing.model_validate_json(path.read_text(encoding="utf-8"))
    except (ValidationError, UnicodeDecodeError):
        raise ConfigError(
            f"{path}: is not the state of a healing; move it away, or name another --out"
        ) from None


def write_healing(folder: Path, healing: Healing) -> None:
    """Replace the state, whole or not at all. Raises RecordingError."""
    with said_of_output(folder / STATE):
        write_whole(folder / STATE, json.dumps(healing.model_dump(mode="json"), indent=1) + "\n")


def digest_of(path: Path) -> str:
    """SHA-256 of a file. Raises OSError."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def exchange(folder: Path, healing: Healing, new_text: str) -> Healing:
    """Put a new text into the robot file; the old one is kept beside the state before that."""
    old = healing.robot_file.read_bytes()
    exchanged = Exchange(
        old_sha256=hashlib.sha256(old).hexdigest(),
        new_sha256=hashlib.sha256(new_text.encode("utf-8")).hexdigest(),
    )
    if exchanged.old_sha256 != healing.old_sha256:
        raise ConfigError(
            f"{healing.robot_file}: was changed while the robot was healed; nothing is replaced,"
            " start again"
        )
    write_whole(folder / BEFORE, old)
    healing = healing.model_copy(update={"exchange": exchanged})
    write_healing(folder, healing)
    write_whole(healing.robot_file, new_text)
    return healing


def undo(folder: Path, robot_file: Path) -> bool:
    """Put the robot file back that was in force before the last correction; False if it is there.

    Raises ConfigError where there is nothing to undo, or the file was changed since.
    """
    healing = read_healing(folder)
    if healing is None or healing.exchange is None:
        raise ConfigError(f"{folder}: no correction was made from here; nothing to undo")
    if healing.robot_file != robot_file.resolve():
        raise ConfigError(f"{folder}: is of {healing.robot_file}, not of {robot_file}")
    now, old = digest_of(robot_file), folder / BEFORE
    if now == healing.exchange.old_sha256:
        return False
    if now != healing.exchange.new_sha256:
        raise ConfigError(
            f"{robot_file}: was changed after it was corrected; the file before that is {old}"
        )
    write_whole(robot_file, old.read_bytes())
    return True
