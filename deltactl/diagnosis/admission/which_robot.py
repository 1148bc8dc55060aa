"""Which robot file a recording is compared with: the one it carries, or one that is named alike."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from deltactl.diagnosis.admission.refusal import refusal, refuse
from deltactl.foundation.errors import RefusedRecording
from deltactl.foundation.strict_yaml import Document
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.writing.retention import ENDING

MAY_DIFFER = ("effects", "networks", "as_built", "recordings")
"""Sections in which two files of one machine may differ: counts mean the same by both."""


def carried_by(recordings: Sequence[Path], robot_file: Path) -> RunConfiguration:
    """Robot and job of the last run among these, which are in order of time.

    robot_file: for tables, which contain none. Raises RefusedRecording where runs are of several
    robots.
    """
    runs = [recording for recording in recordings if recording.suffix == ENDING]
    carried = {one: read_run(one).configuration for one in runs}
    if not runs:
        return RunConfiguration(robot_file.read_text(encoding="utf-8"), "")
    last = runs[-1]
    for one in runs:
        if differing := _differing(carried[one].robot_text, carried[last].robot_text):
            refuse("several_robots", one=one, last=last, differing=", ".join(differing))
    return carried[last]


def _differing(text: str, other: str) -> list[str]:
    one, two = _machine(text), _machine(other)
    return [key for key in {**one, **two} if one.get(key) != two.get(key)]


def _machine(text: str) -> dict[str, Any]:
    data = Document(Path("robot.yaml"), text).data
    return {key: value for key, value in data.items() if key not in MAY_DIFFER}


def no_robot_fits(recording: Path) -> RefusedRecording:
    """What is said of a recording that carries no robot file and is named like none."""
    return refusal("no_robot_fits", str(recording)).error()
