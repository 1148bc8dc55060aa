"""A robot file that was read and checked: here, or in a process of its own."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from deltactl.firmware_py.file_access import FileAccess, Stamp, stamp_of, without_quoting
from deltactl.firmware_py.robot_file import RobotFile, robot_in
from deltactl.foundation.errors import ServiceError
from deltactl.foundation.strict_yaml import Document


@dataclass(frozen=True, slots=True)
class RobotRead:
    """A robot, and the text that says it."""

    robot: RobotFile
    text: str
    stamp: Stamp
    """Of the file before it was read."""

    def message(self) -> dict[str, Any]:
        """As plain values; keys that the file leaves out stay left out."""
        robot = self.robot.model_dump(mode="json", exclude_unset=True)
        return {"robot": robot, "text": self.text, "stamp": self.stamp}

    @classmethod
    def of(cls, message: dict[str, Any]) -> RobotRead:
        """The same again. Raises ServiceError when that is none."""
        try:
            robot = RobotFile.model_validate_json(json.dumps(message["robot"]))
            changed, size, inode = map(int, message["stamp"])
            return cls(robot, str(message["text"]), (changed, size, inode))
        except (KeyError, TypeError, ValueError) as error:
            raise ServiceError(f"the reader's answer cannot be read ({error})") from error


ReadRobot = Callable[[Path, FileAccess], RobotRead]


def read_robot_here(path: Path, access: FileAccess) -> RobotRead:
    """Read and check a robot file in this process. Raises MissingFile, ConfigError."""
    stamp = stamp_of(path)
    with without_quoting(path, access):
        document = Document.read(path, access.follow, access.most_bytes)
        return RobotRead(robot_in(document), document.text, stamp)


def read_robot_once(path: Path, access: FileAccess) -> RobotRead:
    """As `read_robot_here`, or what this access has read before."""
    return RobotRead(access.robot(path), access.document(path).text, access.stamp(path))
