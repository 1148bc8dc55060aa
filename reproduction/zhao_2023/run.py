"""`deltactl reproduce zhao-2023`: all stages, then tables and report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from firmware_py.robot_file import find, load_robot
from foundation.errors import RecordingError
from reproduction.sheet import Sheet
from reproduction.zhao_2023 import report
from reproduction.zhao_2023.as_built import AS_BUILT_FILE, load_as_built
from reproduction.zhao_2023.scale import FULL, QUICK
from reproduction.zhao_2023.study import Say, Study

ROBOT = "zhao-2023.yaml"
REPORT, TABLES = "report.html", "tables.md"


@dataclass(frozen=True)
class Outcome:
    """What was printed and written."""

    sheets: list[Sheet]
    report: Path
    tables: Path


def reproduce(folder: Path, quick: bool, say: Say) -> Outcome:
    """Run what is missing in the folder. Raises ConfigError or RecordingError."""
    robot = load_robot(find(ROBOT))
    built = load_as_built(AS_BUILT_FILE, robot)
    study = Study(folder, robot, built, QUICK if quick else FULL, say)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        sheets = report.sheets(study)
        command = f"deltactl reproduce zhao-2023{' --quick' if quick else ''}"
        (folder / TABLES).write_text(report.markdown(study, command), encoding="utf-8")
        (folder / REPORT).write_text(report.html(study), encoding="utf-8")
    except OSError as error:
        raise RecordingError(
            f"{folder}: cannot be written ({error.strerror or error}); what is done is kept, the "
            "same command goes on from there"
        ) from error
    return Outcome(sheets, folder / REPORT, folder / TABLES)
