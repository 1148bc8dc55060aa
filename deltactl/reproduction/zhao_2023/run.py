"""`deltactl reproduce zhao-2023`: all stages, then tables and report."""

from __future__ import annotations

from pathlib import Path

from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import DeltactlError, RecordingError
from deltactl.reproduction.outcome import Outcome, check_writable, write
from deltactl.reproduction.sheet import Sheet
from deltactl.reproduction.zhao_2023 import beyond, report
from deltactl.reproduction.zhao_2023.as_built import AS_BUILT_FILE, load_as_built
from deltactl.reproduction.zhao_2023.scale import FULL, QUICK
from deltactl.reproduction.zhao_2023.study import Say, Study

ROBOT = "zhao-2023.yaml"


def diagnosed_only(folder: Path, quick: bool, say: Say) -> Sheet:
    """The one table that needs no network. Raises ConfigError or RecordingError."""
    check_writable(folder)
    return beyond.diagnosed(_study(folder, quick, say))


def reproduce(folder: Path, quick: bool, say: Say) -> Outcome:
    """Run what is missing in the folder. Raises ConfigError or RecordingError."""
    check_writable(folder)
    study = _study(folder, quick, say)
    command = f"deltactl reproduce zhao-2023{' --quick' if quick else ''}"
    try:
        sheets = report.sheets(study)
        html, markdown = report.html(study, sheets), report.markdown(study, sheets, command)
    except OSError as error:
        if isinstance(error, DeltactlError):
            raise
        raise RecordingError(
            f"{folder}: cannot be written ({error.strerror or error}); what is done is kept, the "
            "same command goes on from there"
        ) from error
    return write(folder, sheets, html, markdown)


def _study(folder: Path, quick: bool, say: Say) -> Study:
    robot = load_robot(find(ROBOT))
    built = load_as_built(AS_BUILT_FILE, robot)
    return Study(folder, robot, built, QUICK if quick else FULL, say)
