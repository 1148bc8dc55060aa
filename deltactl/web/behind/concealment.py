"""Defects that the simulated robot of the page can conceal, for a diagnosis to find.

What is chosen is written where only the simulated daemon reads it; recordings and the processes
that diagnose them never see it.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.plain_file import write_whole

Entry = dict[str, Any]
NOTHING = "nothing"
SURPRISE = "a surprise"


def _entry(effect: str, component: str, **parameters: float) -> Entry:
    return {"effect": effect, "component": component, "parameters": parameters}


def _upper_arm_3_m(robot: RobotFile) -> float:
    return float(np.ravel(robot.geometry.upper_arm_m)[-1])


DEFECTS: dict[str, Callable[[RobotFile], Entry]] = {
    "motor 2 stands off its home": lambda _: _entry("home_offset", "motor2", angle=0.02),
    "free play in the gearbox of motor 1": lambda _: _entry("gear_backlash", "motor1", width=0.02),
    "friction in the bearings of motor 1": lambda _: _entry("joint_friction", "motor1", width=0.02),
    "the upper arm of arm 3 is 2 % too long": lambda robot: _entry(
        "upper_arm_length", "arm3", length_error=0.02 * _upper_arm_3_m(robot)
    ),
    "the gear ratio of motor 3 is 2 % off": lambda _: _entry("gear_ratio", "motor3", scale=1.02),
    "the y sensor reads 3 % too far": lambda _: _entry("sensor_scale", "range_y", scale=1.03),
}
"""Large enough to be named after one heart of the robot of Zhao 2023."""


class Concealment:
    """One choice, for everybody who looks at the page."""

    def __init__(self, path: Path):
        """path: which the simulated daemon reads when it homes."""
        self._path = path
        self.chosen = NOTHING
        """As it was chosen: a surprise stays one."""
        self.really = NOTHING
        """Which defect that is."""

    @property
    def choices(self) -> list[str]:
        """What can be chosen."""
        return [NOTHING, SURPRISE, *DEFECTS]

    def conceal(self, choice: str, robot: RobotFile) -> None:
        """Write the file anew. Raises KeyError for what is no choice."""
        drawn = secrets.choice(list(DEFECTS)) if choice == SURPRISE else choice
        if drawn == NOTHING:
            self._path.unlink(missing_ok=True)
        else:
            # The daemon reads all of it or the one before.
            write_whole(self._path, yaml.safe_dump({"effects": [DEFECTS[drawn](robot)]}))
        self.chosen, self.really = choice, drawn
