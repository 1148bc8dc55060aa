"""A first job for a new robot: a circle in the middle of what it can reach, as large as fits."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np

from deltactl.firmware_py.program.totals import check_job
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import MotionError
from deltactl.foundation.plain_file import undone_on_failure, write_whole
from deltactl.models.linkage import Linkage, Status, forward
from deltactl.models.robot import per_arm

LEVELS_DEG = (40.0, 60.0, 20.0, 75.0)
"""Arm angles in whose pose the circle may lie: well below level, well above stretched."""
SHARES = (0.4, 0.3, 0.2, 0.1, 0.05, 0.02)
"""Radii tried, as parts of the upper arm; the first that passes the dry run is taken."""
SECONDS = 10.0
CM_MM = 10.0


def write_first_job(robot: RobotFile, robot_file: Path, job_file: Path) -> str | None:
    """Write a circle that the robot may run; returns what it is, None where none passes.

    Raises ConfigError when the robot file itself is refused.
    """
    arm_m = float(per_arm(robot.geometry.upper_arm_m).min())
    for z_m, share in itertools.product(heights_m(robot), SHARES):
        radius_m = float(f"{share * arm_m:.2g}")
        try:
            with undone_on_failure(job_file):
                write_whole(job_file, _text(robot_file, job_file, z_m, radius_m))
                summary = check_job(job_file)
        except MotionError:
            continue
        return (
            f"a circle of {2e3 * radius_m:.3g} mm diameter, {-1e3 * z_m:.4g} mm below the motors, "
            f"{summary.duration_s:.0f} s"
        )
    return None


def cannot_be_built(robot: RobotFile) -> str:
    """What is wrong with the lengths of a robot for which no circle fits; empty where nothing is.

    Stretched, the two parts of an arm have to span what the base is wider than the platform; and a
    forearm is longer than its upper arm, to reach all around.
    """
    base_m, platform_m = robot.geometry.base_radius_m, robot.geometry.platform_radius_m
    gaps_m = np.abs(per_arm(base_m) - per_arm(platform_m))
    uppers_m, forearms_m = per_arm(robot.geometry.upper_arm_m), per_arm(robot.geometry.forearm_m)
    arms_m = uppers_m + forearms_m
    arm = int(np.argmin(arms_m - gaps_m))
    gap_m, upper_m, forearm_m = gaps_m[arm], uppers_m[arm], forearms_m[arm]
    if arms_m[arm] < gap_m:
        said = (
            f"these lengths cannot be assembled: {1e3 * upper_m:g} + {1e3 * forearm_m:g} mm of the"
            f" arm are less than the {1e3 * gap_m:g} mm between the joints of base and platform"
        )
        if CM_MM * arms_m[arm] < gap_m:
            return f"{said}."
        return f"{said}; is the arm in cm? Then write {1e4 * upper_m:g} and {1e4 * forearm_m:g}."
    if (forearms_m <= uppers_m).any():
        return (
            "no circle fits, and the forearm is not longer than the upper arm: are the two"
            " interchanged?"
        )
    return ""


def heights_m(robot: RobotFile) -> list[float]:
    """Where the platform hangs in the poses that can be assembled."""
    linkage = Linkage.of(robot.geometry)
    poses = [forward(linkage, np.full(3, np.deg2rad(level))) for level in LEVELS_DEG]
    return [round(float(one.position_m[2]), 4) for one in poses if one.status == Status.OK]


def _text(robot_file: Path, job_file: Path, z_m: float, radius_m: float) -> str:
    speed = 2.0 * np.pi * radius_m / SECONDS
    return f"""\
# A first job, made by deltactl init.
name: {json.dumps(job_file.stem)}
robot: {json.dumps(robot_file.name)}

path:
  shape: circle
  centre_m: [0.0, 0.0, {z_m:g}]
  radius_m: {radius_m:g}
  spacing_m: {max(1e-6, radius_m / 100.0):.2g}

timing:
  mode: accelerated
  speed_mps: {speed:.3g}

inverse_kinematics: {{kind: geometry}}
"""
