"""A first job for a new robot: a circle in the middle of what it can reach, as large as fits."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from firmware_py.program.dry_run import check_job
from firmware_py.robot_file import RobotFile
from foundation.errors import MotionError
from models.linkage import Linkage, Status, forward
from models.robot import per_arm

LEVELS_DEG = (40.0, 60.0, 20.0, 75.0)
"""Arm angles in whose pose the circle may lie: well below level, well above stretched."""
SHARES = (0.4, 0.3, 0.2, 0.1, 0.05, 0.02)
"""Radii tried, as parts of the upper arm; the first that passes the dry run is taken."""
SECONDS = 10.0


def write_first_job(robot: RobotFile, robot_file: Path, job_file: Path) -> str | None:
    """Write a circle that the robot may run; returns what it is, None where none passes.

    Raises ConfigError when the robot file itself is refused.
    """
    arm_m = float(per_arm(robot.geometry.upper_arm_m).min())
    for z_m, share in itertools.product(_heights_m(robot), SHARES):
        radius_m = float(f"{share * arm_m:.2g}")
        job_file.write_text(_text(robot_file, job_file, z_m, radius_m), encoding="utf-8")
        try:
            summary = check_job(job_file)
        except MotionError:
            continue
        return (
            f"a circle of {2e3 * radius_m:.3g} mm diameter, {-1e3 * z_m:.4g} mm below the motors, "
            f"{summary.duration_s:.0f} s"
        )
    job_file.unlink(missing_ok=True)
    return None


def arms_interchanged(robot: RobotFile) -> bool:
    """Whether a forearm is not longer than its upper arm, as it has to be to reach all around."""
    upper_m, forearm_m = robot.geometry.upper_arm_m, robot.geometry.forearm_m
    return bool((per_arm(forearm_m) <= per_arm(upper_m)).any())


def _heights_m(robot: RobotFile) -> list[float]:
    """Where the platform hangs in the poses that can be assembled."""
    linkage = Linkage.of(robot.geometry)
    poses = [forward(linkage, np.full(3, np.deg2rad(level))) for level in LEVELS_DEG]
    return [round(float(one.position_m[2]), 4) for one in poses if one.status == Status.OK]


def _text(robot_file: Path, job_file: Path, z_m: float, radius_m: float) -> str:
    speed = 2.0 * np.pi * radius_m / SECONDS
    return f"""\
# A first job, made by deltactl init.
name: {job_file.stem}
robot: {robot_file.name}

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
