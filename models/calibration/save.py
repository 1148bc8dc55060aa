"""The calibrated robot as a robot file: what was believed, and the effects that were found."""

from __future__ import annotations

from pathlib import Path

import yaml

from foundation.errors import RecordingError
from foundation.strict_yaml import Document
from models.calibration.fit import Calibration


def save_calibrated(robot_file: Path, calibration: Calibration, words: str, out: Path) -> None:
    """Write the robot file with the effects; comments stay. Raises RecordingError.

    A job with `inverse_kinematics: {kind: calibrated}` takes them into account.
    """
    document = Document.read(robot_file)
    if document.data.get("effects"):
        raise RecordingError(
            f"{robot_file}: has effects already; calibrate with the file as it was designed"
        )
    entries = [entry.model_dump(mode="json") for entry in calibration.robot.effects]
    block = yaml.safe_dump({"effects": entries}, sort_keys=False)
    text = f"{document.text.rstrip()}\n\n# Calibrated on {words}; known from now on.\n{block}"
    try:
        with out.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise RecordingError(f"{out}: exists already; choose another name") from None
    except OSError as error:
        raise RecordingError(f"{out}: cannot be written ({error.strerror})") from error
