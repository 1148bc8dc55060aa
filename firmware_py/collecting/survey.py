"""A survey: the counts it commands, the position seen at each, and what its data set says of it."""

from __future__ import annotations

import importlib.metadata
import platform
from typing import Any, Literal

import numpy as np

from deltactl.firmware_py.paths.survey import off_singular, survey
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError
from deltactl.models.linkage import Linkage
from deltactl.models.network.metadata import fingerprint
from deltactl.models.robot import FloatArray, Sensors
from deltactl.models.training.dataset import DataSettings

FEWEST = 5
"""Good readings of a sensor below which a pose counts as not seen."""
OUTLIER_M = 0.015
"""Readings this far from the median are not averaged."""


def at_rest(sensors: Sensors, ranges_m: list[FloatArray]) -> FloatArray | None:
    """The position [m] (3,) for good ranges of each sensor [m] (n,); None when one saw too little.

    The mean of what lies near the median: readings come in whole millimetres, and a few are wrong
    by centimetres.
    """
    means = np.empty(3)
    for sensor, values in enumerate(ranges_m):
        if len(values) < FEWEST:
            return None
        near = np.abs(values - np.median(values)) <= OUTLIER_M
        means[sensor] = values[near].mean()
    position: FloatArray = np.linalg.solve(sensors.axes, means - sensors.offsets_m)
    return position


IntArray = np.ndarray[Any, np.dtype[np.int64]]


def survey_counts(robot: RobotFile, count: int, seed: int) -> IntArray:
    """Random counts within the arm limits (Zhao 2023, section 3), (count, 3).

    The same seed gives the same counts, a larger count adds to them. Raises UnreachablePoint.
    """
    limits = robot.limits
    spare = off_singular(Linkage.of(robot.geometry), limits.singularity_margin)
    path = survey(spare, count, limits.arm_deg, 0.0, seed)
    counts: IntArray = np.rint(path.targets / robot.drive.rad_per_step).astype(np.int64)
    return counts


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
