"""What ran: the files, the version and the settings that a recording carries with it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from deltactl.foundation.errors import RecordingError
from deltactl.foundation.printable import printable
from deltactl.recording.format.channels import FORMAT

METADATA_NAME = "deltactl"
ROBOT_ATTACHMENT = "robot.yaml"
JOB_ATTACHMENT = "job.yaml"


@dataclass(frozen=True, slots=True)
class RunConfiguration:
    """Everything needed to understand a recording years later.

    `settings` must be plain JSON types. `start_epoch_ns` is the wall clock at run time 0.
    """

    robot_text: str
    job_text: str
    robot_name: str = ""
    job_name: str = ""
    version: str = ""
    simulated: bool = False
    start_epoch_ns: int = 0
    settings: Mapping[str, Any] = field(default_factory=dict)

    def as_message(self) -> dict[str, int | str]:
        """The fields of the `/configuration` message."""
        return {
            "t_ns": 0,
            "format": FORMAT,
            "robot_name": self.robot_name,
            "job_name": self.job_name,
            "version": self.version,
            "start_epoch_ns": self.start_epoch_ns,
            "simulated": int(self.simulated),
            "robot_text": self.robot_text,
            "job_text": self.job_text,
            "settings_json": json.dumps(dict(self.settings), sort_keys=True),
        }

    def as_metadata(self) -> dict[str, str]:
        """The short facts, as MCAP metadata."""
        return {
            "format": str(FORMAT),
            "robot": self.robot_name,
            "job": self.job_name,
            "version": self.version,
            "simulated": "yes" if self.simulated else "no",
            "start_epoch_ns": str(self.start_epoch_ns),
            "settings": json.dumps(dict(self.settings), sort_keys=True),
        }


def from_message(message: Mapping[str, Any]) -> RunConfiguration:
    """The configuration a `/configuration` message describes.

    Raises RecordingError when a newer program wrote it.
    """
    if (found := int(message["format"])) > FORMAT:
        raise RecordingError(
            f"was written by a newer deltactl ({message['version']}, format {found}); "
            f"this one reads format {FORMAT}"
        )
    return RunConfiguration(
        robot_text=str(message["robot_text"]),
        job_text=str(message["job_text"]),
        robot_name=printable(str(message["robot_name"])),
        job_name=printable(str(message["job_name"])),
        version=printable(str(message["version"])),
        simulated=bool(message["simulated"]),
        start_epoch_ns=int(message["start_epoch_ns"]),
        settings=json.loads(message["settings_json"]),
    )
