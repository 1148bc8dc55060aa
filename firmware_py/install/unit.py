"""The files of `systemd/`, filled in for this machine and robot."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from pathlib import Path

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.places import IMPORT_ROOT, PACKAGE

PROGRAM = IMPORT_ROOT
"""Of a working copy, the folder that holds the docs too."""
TEMPLATES = PACKAGE / "systemd"

ANY_CHIP = "char-gpiochip"
"""All GPIO chips, as systemd names a group of devices: kernels number them differently, so the
header's is found by its label when the daemon starts, and not when the unit is written."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where things are on this machine. `bin` holds this environment's python and deltactl."""

    robot_file: Path
    program: Path = PROGRAM
    bin: Path = Path(sys.executable).parent


def service_unit(robot: RobotFile, place: Place) -> str:
    """The text of deltactl.service. Raises ConfigError for paths that systemd cannot take."""
    names = {
        "BIN": str(place.bin),
        "PROGRAM": str(place.program),
        "ROBOT": str(place.robot_file),
        "GPIOCHIP": ANY_CHIP if robot.steps.chip is None else f"/dev/gpiochip{robot.steps.chip}",
        "I2C": f"/dev/i2c-{robot.ranging.bus}",
    }
    for value in names.values():
        if not re.fullmatch(r"[A-Za-z0-9/._+-]+", value):
            raise ConfigError(
                f"{value}: a path in a systemd unit may hold letters, digits and . _ + - only;"
                " move the project or the robot file"
            )
    return re.sub(r"@([A-Z0-9]+)@", lambda found: names[found[1]], template("deltactl.service"))


def template(name: str) -> str:
    """A file of `systemd/` as it stands."""
    return (TEMPLATES / name).read_text()
