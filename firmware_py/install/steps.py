"""The steps of an installation, each of which says what it would do and does it; and their texts.

The files of `systemd/`, filled in for this machine and robot, and what config.txt must say, added
without touching the rest.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Protocol

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError, ServiceError
from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.process import IMPORT_ROOT, PACKAGE

BOOT_FILES: Final = ("boot/firmware/config.txt", "boot/config.txt")
"""Raspberry Pi OS 12 and later, and before; relative to the root."""

WANTED: Final[dict[str, str]] = {
    "i2c_arm": "on",
    "i2c_arm_baudrate": "400000",  # VL53L1X: three readings of 17 bytes take 2 ms, not 7
}
"""dtparam names and values (firmware documentation, overlays/README)."""

MARK: Final = "# deltactl: the I2C bus of the distance sensors"


def boot_file(root: Path) -> Path | None:
    """The config.txt of this Pi; None when there is none."""
    return next((root / name for name in BOOT_FILES if (root / name).is_file()), None)


def with_options(text: str) -> str:
    """config.txt with what is missing added at its end; unchanged when nothing is."""
    found = active_parameters(text)
    missing = [
        f"dtparam={name}={value}" for name, value in WANTED.items() if found.get(name) != value
    ]
    if not missing:
        return text
    head = text if text.endswith("\n") or not text else text + "\n"
    # [all] ends whatever section ([pi4], [cm5], ...) the file ends in; later lines win.
    return head + "\n".join(["", "[all]", MARK, *missing, ""])


def active_parameters(text: str) -> dict[str, str]:
    """dtparam settings that hold for every model, as the firmware reads them: the last one wins."""
    return {
        name: value
        for line in _lines_for_all(text)
        if line.startswith("dtparam=")
        for name, value in _settings(line.removeprefix("dtparam="))
    }


def _lines_for_all(text: str) -> Iterator[str]:
    everywhere = True
    for raw in text.splitlines():
        line = raw.split("#", 1)[0].strip()
        if line.startswith("[") and line.endswith("]"):
            everywhere = line == "[all]"
        elif everywhere:
            yield line


def _settings(text: str) -> Iterator[tuple[str, str]]:
    """`i2c_arm=on,i2c_arm_baudrate=400000` holds two; a bare name means on."""
    for part in text.split(","):
        name, _, value = part.partition("=")
        name = {"i2c": "i2c_arm", "i2c_baudrate": "i2c_arm_baudrate"}.get(
            name.strip(), name.strip()
        )
        yield name, value.strip() or "on"


PROGRAM = IMPORT_ROOT
"""Folder of the program; in a working copy it holds the docs too."""
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
    """A file of `systemd/`, unchanged."""
    return (TEMPLATES / name).read_text()


BACKUP = ".before-deltactl"
EVERYBODY_READS = 0o644
"""Permissions of a new file; one that is changed keeps its own."""


class Step(Protocol):
    """One thing to do. Doing it twice is harmless."""

    def describe(self) -> str:
        """What it would do, or that nothing is left to do; one line."""

    def apply(self) -> None:
        """Do it. Raises ServiceError."""


@dataclass(frozen=True, slots=True)
class WriteFile:
    """Put a text into a file; what stood there before is kept beside it."""

    path: Path
    text: str
    why: str

    def describe(self) -> str:
        before = text_of(self.path)
        if before == self.text:
            return f"keep     {self.path} (is as it should be)"
        if before is None:
            return f"write    {self.path} ({self.why})"
        return f"change   {self.path} ({self.why}); the old one is kept as {self._backup().name}"

    def apply(self) -> None:
        before = text_of(self.path)
        if before == self.text:
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            if before is not None:
                write_whole(self._backup(), before)
            # Also when the power goes: a Pi without config.txt does not boot.
            write_whole(self.path, self.text, mode=EVERYBODY_READS if before is None else None)
        except OSError as error:
            raise ServiceError(f"{self.path}: cannot be written ({error.strerror})") from error

    def _backup(self) -> Path:
        first = self.path.with_name(self.path.name + BACKUP)
        places = [first, *(first.with_name(f"{first.name}-{number}") for number in range(2, 1000))]
        return next(place for place in places if not place.exists())


@dataclass(frozen=True, slots=True)
class Run:
    """Run a command."""

    command: tuple[str, ...]
    why: str

    def describe(self) -> str:
        return f"run      {shlex.join(self.command)} ({self.why})"

    def apply(self) -> None:
        try:
            done = subprocess.run(self.command, capture_output=True, text=True, check=False)
        except OSError as error:
            raise ServiceError(f"{self.command[0]}: cannot be run ({error.strerror})") from error
        if done.returncode != 0:
            said = " ".join((done.stderr or done.stdout).split())[-300:]
            raise ServiceError(f"{shlex.join(self.command)}: failed ({said})")


def text_of(path: Path) -> str | None:
    """Text of a file; None when there is none. Raises ServiceError."""
    try:
        return path.read_text()
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise ServiceError(f"{path}: cannot be read ({error})") from error
