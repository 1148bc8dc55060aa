"""What a simulated robot is really like, in a file apart from the robot file.

Recordings carry the robot file, so what stands in it is known to whoever diagnoses them; this file
goes into no recording.
"""

from __future__ import annotations

from pathlib import Path

from deltactl.foundation.errors import MissingFile
from deltactl.foundation.strict_yaml import Document, StrictModel
from deltactl.models.chain.active import of_entries
from deltactl.models.robot import EffectEntry

Effects = tuple[EffectEntry, ...]


class AsBuiltFile(StrictModel):
    """All the effects that the simulated robot has; what the robot file says is only believed."""

    effects: Effects


class Concealed:
    """Such a file, read again whenever the arms are put against their stops."""

    def __init__(self, path: Path):
        self._path = path

    def effects(self) -> Effects | None:
        """None while there is no such file. Raises ConfigError."""
        try:
            found = Document.read(self._path).check(AsBuiltFile).effects
        except MissingFile:
            return None
        of_entries(found)
        return found


def nothing_apart() -> Effects | None:
    """For a simulated robot that has no such file."""
    return None
