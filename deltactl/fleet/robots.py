"""Which robot a recording is of, and when it was made."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from deltactl.foundation.errors import ConfigError, RecordingError
from deltactl.foundation.strict_yaml import Document

_DATE = re.compile(r"(\d{4})-(\d\d)-(\d\d)(?:[T_](\d\d)-?(\d\d)-?(\d\d))?")


@dataclass(frozen=True)
class Robots:
    """Robot files of a folder: by the name of the file, and by the name inside."""

    by_stem: dict[str, Path]
    by_name: dict[str, Path]

    @classmethod
    def in_folder(cls, folder: Path) -> Robots:
        """Read the names. Raises ConfigError when there are none, or one name stands twice."""
        stems: dict[str, Path] = {}
        names: dict[str, Path] = {}
        for path in sorted(folder.glob("*.yaml")):
            try:
                data = Document.read(path).data
            except ConfigError:  # its recordings will say so, each in its row
                stems[path.stem] = path
                continue
            if "kind" not in data:
                continue  # a job
            stems[path.stem] = path
            name = str(data.get("name", path.stem))
            if name in names:
                raise ConfigError(f"{path}: {names[name].name} is called '{name}' too; rename one")
            names[name] = path
        if not stems:
            raise ConfigError(f"{folder}: no robot file (.yaml with 'kind') lies there")
        return cls(stems, names)

    def of(self, recording: Path) -> tuple[str, Path]:
        """Name and file of a recording's robot: as the recording says, or by its folder or name.

        Raises RecordingError.
        """
        if recording.suffix == ".mcap":
            from deltactl.recording.reading.reader import read_run

            said = read_run(recording).configuration.robot_name
            if said in self.by_name:
                return said, self.by_name[said]
        for part in (recording.name, *reversed(recording.parent.parts)):
            fitting = [stem for stem in self.by_stem if _begins(part, stem)]
            if fitting:
                stem = max(fitting, key=len)
                return stem, self.by_stem[stem]
        raise RecordingError(
            f"{recording}: no robot file fits; name its folder, or the beginning of its name, "
            "like the robot file"
        )


def recorded_at(recording: Path) -> datetime:
    """When a run was: as it says, by a date in its name, or when the file was written."""
    if recording.suffix == ".mcap":
        from deltactl.recording.reading.reader import read_run

        epoch_ns = read_run(recording).configuration.start_epoch_ns
        if epoch_ns > 0:
            return datetime.fromtimestamp(epoch_ns / 1e9, UTC)
    if (found := _DATE.search(recording.name)) is not None:
        parts = [int(part) for part in found.groups() if part is not None]
        try:
            return datetime(*parts, tzinfo=UTC)  # type: ignore[arg-type, misc]
        except ValueError:
            pass  # digits that are no date
    return datetime.fromtimestamp(recording.stat().st_mtime, UTC)


def _begins(part: str, stem: str) -> bool:
    """Whether a name is the stem, or begins with it and something that is not part of a word."""
    return part.startswith(stem) and not part[len(stem) : len(stem) + 1].isalnum()
