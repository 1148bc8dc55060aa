"""What a data set says about how it was taken."""

from __future__ import annotations

import importlib.metadata
import platform
from typing import Literal

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError
from deltactl.models.network.metadata import fingerprint
from deltactl.models.training.dataset import DataSettings

T_PWM_S = 0.006
"""Zhao 2023, section 3."""
DWELL_S = 0.5
"""25 readings of each sensor at rest."""


def settings_of(
    robot: RobotFile,
    machine: Literal["robot", "simulated", "as-built"],
    seed: int,
    as_built: str = "",
    source: str = "survey",
    t_pwm_s: float = T_PWM_S,
) -> DataSettings:
    """Settings of a data set taken now. Raises ConfigError without sensors in the robot file."""
    if robot.sensors is None:
        raise ConfigError(f"robot '{robot.name}' has no section 'sensors'; nothing can be measured")
    return DataSettings(
        robot=robot.name,
        fingerprint=fingerprint(robot.geometry),
        geometry=robot.geometry,
        drive=robot.drive,
        sensors=robot.sensors,
        machine=machine,
        as_built=as_built,
        source=source,
        seed=seed,
        angle_deg=robot.limits.arm_deg,
        t_pwm_s=t_pwm_s,
        dwell_s=DWELL_S,
        versions=_versions(),
    )


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for name in ("deltactl", "numpy", "mujoco"):
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found
