"""Do the ranges that are there say where all three arms are, and what would go unseen?"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import ARMS, FloatArray

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
NUDGE_RAD = 1e-4
LEAST_SLOPE_MPRAD = 0.01
"""A direction of the arms in which a whole radian moves no range by more is not seen."""
LOOKS = 27
"""Angles tried of each arm where the ranges do not determine them."""


def range_slopes_m(robot: RobotFile, angles_rad: FloatArray) -> FloatArray:
    """Change of each range with a radian of each arm; shape (3, 3). The robot needs sensors."""
    assert robot.sensors is not None
    nudged = angles_rad + NUDGE_RAD * np.vstack([np.zeros(3), np.eye(3)])
    ranges_m = forward(Linkage.of(robot.geometry), nudged).position_m @ robot.sensors.axes.T
    slopes_m: FloatArray = ((ranges_m[1:] - ranges_m[0]) / NUDGE_RAD).T
    return slopes_m


def determine(robot: RobotFile, good: BoolArray) -> bool:
    """Whether these ranges determine all arms at the home angles: rank 3 of their slopes there."""
    if robot.sensors is None:
        return False
    slopes_m = range_slopes_m(robot, np.deg2rad(robot.homing.angle_deg))[good]
    return len(slopes_m) > 0 and np.linalg.matrix_rank(slopes_m, tol=LEAST_SLOPE_MPRAD) == 3


def unseen_rad(robot: RobotFile, good: BoolArray, agree_m: float) -> float:
    """The furthest an arm may be from home while these ranges are within `agree_m` of it [rad].

    Where the ranges determine the arms this is the linear estimate at home; elsewhere the arms
    are tried throughout `limits.arm_deg`.
    """
    home_rad = np.deg2rad(robot.homing.angle_deg)
    if determine(robot, good):
        to_arms = np.linalg.pinv(range_slopes_m(robot, home_rad)[good])
        return float(np.abs(to_arms).sum(axis=1).max()) * agree_m
    return _furthest_rad(robot, good, home_rad, agree_m)


def unseen_deg(robot: RobotFile, good: BoolArray) -> int:
    """The same in whole degrees, rounded up, as `--accept-unseen` takes it."""
    return math.ceil(math.degrees(unseen_rad(robot, good, robot.homing.tolerance_m)) - 1e-6)


def unseen_by_none_deg(robot: RobotFile) -> int:
    """The same where no sensor looks."""
    return unseen_deg(robot, np.zeros(ARMS, dtype=np.bool_))


def _furthest_rad(robot: RobotFile, good: BoolArray, home_rad: FloatArray, agree_m: float) -> float:
    low_rad, high_rad = np.deg2rad(robot.limits.arm_deg)
    looks_rad = np.linspace(low_rad, high_rad, LOOKS)
    angles_rad = np.array(list(itertools.product(looks_rad, repeat=3)))
    off_rad = np.abs(angles_rad - home_rad).max(axis=1)
    if robot.sensors is None or not good.any():
        return float(off_rad.max())
    linkage = Linkage.of(robot.geometry)
    here_m = forward(linkage, home_rad).position_m
    there_m = forward(linkage, angles_rad).position_m
    differ_m = np.abs((there_m - here_m) @ robot.sensors.axes[good].T)
    # Half a grid's way, so that what lies between two looks is not left out.
    between_m = float(np.abs(range_slopes_m(robot, home_rad)[good]).sum(axis=1).max())
    reach_m = agree_m + between_m * float(looks_rad[1] - looks_rad[0]) / 2.0
    alike = (differ_m <= reach_m).all(axis=1)
    return float(off_rad[alike].max()) if alike.any() else 0.0
