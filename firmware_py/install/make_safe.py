"""Leave the lines safe: no step, drives released, outputs in their safe state.

systemd runs it after the daemon has ended:
`python -m deltactl.firmware_py.install.make_safe ROBOT.yaml [--hold]`. The text that was in force
in the daemon counts; the file is for a daemon that kept none. With --hold ENA is left as it is, so
that the arms do not drop. Whatever fails is said in one line and never fails the unit:
the exit status is always 0.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

from deltactl.drivers.steps.build import release_drives
from deltactl.firmware_py.controller.file_in_force import kept_text
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import DeltactlError


def make_safe(robot: RobotFile, *, hold: bool = False, gpio: Any | None = None) -> str:
    """Claim the outputs at their safe levels and let them go; returns what was done.

    Raises PulseFault when the chip or a line cannot be had. gpio: a substitute for lgpio.
    """
    return release_drives(robot.steps, robot.inputs, robot.switches, hold=hold, gpio=gpio)


def main(arguments: list[str]) -> int:
    """Always 0."""
    hold = "--hold" in arguments
    files = [word for word in arguments if not word.startswith("--")]
    try:
        if len(files) != 1:
            said = "no lines made safe: name one robot file"
        else:
            said = _with_a_folder_for_lgpio(_in_force(Path(files[0])), hold)
    except DeltactlError as error:
        said = f"no lines made safe: {' '.join(str(error).split())}"
    except Exception as error:
        said = f"no lines made safe: {type(error).__name__}: {' '.join(str(error).split())}"
    print(f"deltactl: {said}", file=sys.stderr)
    return 0


def _in_force(named: Path) -> RobotFile:
    """The robot whose lines the daemon had. Raises ConfigError where neither text can be used."""
    kept = kept_text()
    if kept is not None:
        with contextlib.suppress(DeltactlError):
            return load_robot(kept)
    return load_robot(named)


def _with_a_folder_for_lgpio(robot: RobotFile, hold: bool) -> str:
    """lgpio puts a pipe into LG_WD when it is loaded, and changes into that folder."""
    with tempfile.TemporaryDirectory(prefix="deltactl-safe-", ignore_cleanup_errors=True) as folder:
        os.environ.setdefault("LG_WD", folder)
        try:
            return make_safe(robot, hold=hold)
        finally:
            os.chdir("/")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
