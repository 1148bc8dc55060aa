"""The robot file that a controller uses, and when it may take another without a restart.

Taking another is for a robot that is off, or that is about to be homed: counts mean nothing then.
"""

from __future__ import annotations

from pathlib import Path

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError

BUILT_IN = ("name", "drive", "steps", "inputs", "outputs", "ranging", "recordings")
"""Sections from which pins, sensors, clocks and the keeper of recordings were built."""


def needs_restart(accepted: RobotFile, new: RobotFile) -> str:
    """The section for which the process must start anew; empty where it can go on."""
    for section in BUILT_IN:
        if getattr(accepted, section) != getattr(new, section):
            return section
    if (accepted.sensors is None) != (new.sensors is None):
        return "sensors"
    switches = [
        (one.homing.method, one.homing.switch_pins, one.homing.switch_active_high)
        for one in (accepted, new)
    ]
    if switches[0] != switches[1]:
        return "homing"
    built = [(one.as_built.noise, one.as_built.servo) for one in (accepted, new)]
    if built[0] != built[1] or (accepted.drive.kind == "servo" and accepted != new):
        return "as_built"
    return ""


def other_accepted(accepted: RobotFile, new: RobotFile, path: Path) -> RobotFile:
    """Another file of the same machine, to use instead; the simulated robot stays as it is.

    Raises ConfigError.
    """
    if not accepted.is_machine_of(new):
        raise ConfigError(
            f"{path}: describes another machine than the one that runs (only the name, effects,"
            " networks, as_built and recordings may differ); restart the daemon with it"
        )
    truth = accepted.as_built.model_copy(update={"effects": accepted.effects_as_built})
    update = {"name": accepted.name, "as_built": truth, "recordings": accepted.recordings}
    return new.model_copy(update=update)
