"""What it does to a run that home is counted in whole microsteps.

The arms rest where the stops are, which is between two counts: all the way through they stand off
what the counts say by the rest, up to half a microstep each.
"""

from __future__ import annotations

import numpy as np

from deltactl.firmware_py.planner.check import home_counts
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.run_report.reference import arrivals
from deltactl.firmware_py.run_report.tracking import RunTracking, asked_path, positions_of_counts
from deltactl.models.robot import AXES, FloatArray
from deltactl.models.servo_drive import ServoDrive
from deltactl.recording.reading.run import Run

TELLS = 0.8
"""Share of an axis' error, at most, that is left without this where it is told."""
ROUNDED = "Home itself is rounded to whole microsteps: up to {:.2f} mm of that are in {}."


def said_of_home(run: Run, robot: RobotFile, tracking: RunTracking) -> str:
    """One line where the truth of a simulated run is off by that; empty where it is not."""
    truth = tracking.truth
    if truth is None or isinstance(robot.drive, ServoDrive) or not len(run.targets.t_ns):
        return ""
    moved_m = moved_by_home_m(run, robot)
    mean_m = moved_m.mean(axis=0)
    errors_m = truth.error_m[np.isfinite(truth.error_m).all(axis=1)]
    if not len(errors_m):
        return ""
    left_m, all_m = (np.sqrt(np.mean(x**2, axis=0)) for x in (errors_m - mean_m, errors_m))
    told = [axis for axis, some, every in zip(AXES, left_m, all_m, strict=True)
            if some < TELLS * every]  # fmt: skip
    if not told:
        return ""
    most = max(told, key=lambda axis: abs(mean_m[AXES.index(axis)]))
    return ROUNDED.format(1e3 * float(np.abs(moved_m[:, AXES.index(most)]).max()), most)


def moved_by_home_m(run: Run, robot: RobotFile) -> FloatArray:
    """How far the platform stands off at each target, (n, 3), as home is between two counts."""
    home_rad = np.deg2rad(robot.homing.angle_deg)
    off_steps = home_rad / robot.drive.rad_per_step - np.array(home_counts(robot))
    asked = asked_path(run, robot)
    counts = asked.targets.steps[arrivals(asked)]
    there_m = positions_of_counts(robot, counts)
    moved: FloatArray = positions_of_counts(robot, counts + off_steps) - there_m
    return moved
