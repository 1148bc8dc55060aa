"""A delta as a tree of links and joints, which URDF and ROS need, and the places of all joints.

A delta has closed loops, and a tree has none. The platform hangs on arm 1, where mimic joints keep
it level, which is exact: the forearm's two rods are one link in their middle, and what turns at the
elbow turns back at the wrist. The loops are cut at the lower ends of forearms 2 and 3. They meet
the platform wherever all joints have the places that `places` gives for three arm angles.

Frames: that of the robot for the base; in an arm x points outwards, z up. All joints are 0 with
level upper arms and vertical forearms. The robot is that of the file with its known effects, as far
as geometry has them: lengths, directions, homes, gears; not play, friction or what a table says.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.linkage import Linkage, forward, inverse
from deltactl.models.robot import ARMS, DeltaRobot, FloatArray, per_arm

Place = tuple[float, float, float]
BASE, PLATFORM = "base_link", "platform"
MOTOR, LEVEL, SWING, TILT, WRIST_TILT, WRIST_SWING = (
    *("motor", "elbow_level", "elbow_swing"),
    *("elbow_tilt", "wrist_tilt", "wrist_swing"),
)
ABOUT = {MOTOR: 1, LEVEL: 1, SWING: 1, TILT: 0, WRIST_TILT: 0, WRIST_SWING: 1}
"""The axis of each kind of joint: 0 is x, 1 is y."""
MIDDLE_M = 0.85
"""The drawing of a robot assembles it at this share of its reach; any pose would do."""


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint of the tree: `child` is at `origin_m`, turned by `yaw_rad` about z, in `parent`,
    and turns by the joint's place about `about` (0 is x, 1 is y; None: it is fixed).

    mimics: the joint whose place, times -1, is this one's.
    """

    name: str
    parent: str
    child: str
    origin_m: Place
    yaw_rad: float = 0.0
    about: int | None = None
    mimics: str = ""


class Arm(NamedTuple):
    """Lengths [m] and direction [rad] of one arm."""

    base_radius_m: float
    platform_radius_m: float
    upper_arm_m: float
    forearm_m: float
    azimuth_rad: float


def linkage_of(robot: DeltaRobot) -> Linkage:
    """The linkage, with what the robot's effects correct of it."""
    return CalibratedInverse(robot).linkage


def arms_of(robot: DeltaRobot) -> list[Arm]:
    """The three arms; what effects correct of the base's radius is taken off the platform's."""
    linkage = linkage_of(robot)
    base_m = per_arm(robot.geometry.base_radius_m)
    columns = (
        base_m,
        base_m - np.broadcast_to(linkage.radius_m, ARMS),
        *(np.broadcast_to(value, ARMS) for value in (linkage.upper_arm_m, linkage.forearm_m)),
        np.broadcast_to(linkage.azimuth_rad, ARMS),
    )
    return [Arm(*row) for row in np.stack(columns, axis=1).tolist()]


def joints_of(robot: DeltaRobot) -> list[Joint]:
    """The joints, parents before children."""
    return [joint for number, arm in enumerate(arms_of(robot), 1) for joint in _arm(number, arm)]


def _arm(number: int, arm: Arm) -> Iterator[Joint]:
    n, here = number, (0.0, 0.0, 0.0)
    out, elbow, down = (arm.base_radius_m, 0.0, 0.0), (arm.upper_arm_m, 0.0, 0.0), -arm.forearm_m
    yield Joint(
        f"shoulder_{n}", BASE, f"shoulder_{n}_link", _turned(out, arm.azimuth_rad), arm.azimuth_rad
    )
    yield _joint(n, MOTOR, f"shoulder_{n}_link", f"upper_arm_{n}", here)
    yield _joint(n, LEVEL, f"upper_arm_{n}", f"elbow_{n}", elbow, MOTOR)
    yield _joint(n, SWING, f"elbow_{n}", f"elbow_cross_{n}", here)
    yield _joint(n, TILT, f"elbow_cross_{n}", f"forearm_{n}", here)
    if number > 1:
        return
    yield _joint(n, WRIST_TILT, f"forearm_{n}", f"wrist_cross_{n}", (0.0, 0.0, down), TILT)
    yield _joint(n, WRIST_SWING, f"wrist_cross_{n}", f"wrist_{n}", here, SWING)
    inwards = (-arm.platform_radius_m, 0.0, 0.0)
    yield Joint("platform_mount", f"wrist_{n}", PLATFORM, inwards, -arm.azimuth_rad)


def _joint(n: int, kind: str, parent: str, child: str, at: Place, mimics: str = "") -> Joint:
    followed = f"{mimics}_{n}" if mimics else ""
    return Joint(f"{kind}_{n}", parent, child, at, about=ABOUT[kind], mimics=followed)


def _turned(place: Place, yaw_rad: float) -> Place:
    x, y, z = place
    cosine, sine = math.cos(yaw_rad), math.sin(yaw_rad)
    return cosine * x - sine * y, sine * x + cosine * y, z


def places(robot: DeltaRobot, commanded_rad: FloatArray) -> dict[str, FloatArray]:
    """The places [rad] of all joints that turn, shape (n,) each, for commanded arm angles (n, 3).

    NaN where the linkage cannot be assembled.
    """
    found: dict[str, FloatArray] = {}
    true_rad, position_m = pose(robot, commanded_rad)
    for column, arm in enumerate(arms_of(robot)):
        n, turned = column + 1, true_rad[:, column]
        rod = _rod(arm, turned, position_m)
        swing, tilt = np.arctan2(-rod[:, 0], -rod[:, 2]), np.arcsin(rod[:, 1] / arm.forearm_m)
        found |= {f"{MOTOR}_{n}": turned, f"{LEVEL}_{n}": -turned}
        found |= {f"{SWING}_{n}": swing, f"{TILT}_{n}": tilt}
        if n == 1:
            found |= {f"{WRIST_TILT}_{n}": -tilt, f"{WRIST_SWING}_{n}": -swing}
    return found


def pose(robot: DeltaRobot, commanded_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """True arm angles [rad] and the platform [m] for commanded arm angles, all (n, 3)."""
    kinematics = CalibratedInverse(robot)
    achieved_rad = kinematics.achieved_rad(np.asarray(commanded_rad, dtype=np.float64))
    position_m = forward(kinematics.linkage, achieved_rad).position_m
    return achieved_rad + kinematics.linkage.home_offset_rad, position_m


def _rod(arm: Arm, true_rad: FloatArray, position_m: FloatArray) -> FloatArray:
    """From elbow to wrist in the arm's frame [m], shape (n, 3)."""
    cosine, sine = math.cos(arm.azimuth_rad), math.sin(arm.azimuth_rad)
    x_m = cosine * position_m[:, 0] + sine * position_m[:, 1] + arm.platform_radius_m
    y_m = cosine * position_m[:, 1] - sine * position_m[:, 0]
    reach_m = arm.base_radius_m + arm.upper_arm_m * np.cos(true_rad)
    drop_m = position_m[:, 2] + arm.upper_arm_m * np.sin(true_rad)
    return np.stack([x_m - reach_m, y_m, drop_m], axis=1)


def middle_rad(robot: DeltaRobot) -> FloatArray:
    """Commanded angles, shape (3,), of a pose in which the robot can be assembled.

    Below the base's middle, as far down as a share of the reach, nearer where that is too far.
    """
    linkage = linkage_of(robot)
    longest_m = float(np.min(linkage.upper_arm_m) + np.min(linkage.forearm_m))
    heights_m = -longest_m * np.linspace(MIDDLE_M, 0.1, 60)
    angles = inverse(linkage, np.stack([0 * heights_m, 0 * heights_m, heights_m], axis=1))
    good = np.flatnonzero(angles.status == 0)
    first: FloatArray = angles.angles_rad[good[0] if len(good) else 0]
    return first


def limits_rad(robot: RobotFile, arm: int) -> tuple[float, float]:
    """Lowest and highest true angle of an arm: the file's limits are of commanded angles."""
    commanded_rad = np.deg2rad(np.repeat(np.array(robot.limits.arm_deg)[:, None], ARMS, axis=1))
    low_rad, high_rad = pose(robot, commanded_rad)[0][:, arm].tolist()
    return low_rad, high_rad
