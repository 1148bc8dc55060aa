"""Whether the sensors show that the arms are at home, and how far they could be off unseen."""

from __future__ import annotations

import numpy as np

from deltactl.firmware_py.controller.contract import HomeSeen
from deltactl.firmware_py.controller.sensing.determined import BoolArray, determine, unseen_deg
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import NotReady
from deltactl.models.chain import Chain, Commands
from deltactl.models.robot import AXES, FloatArray


def expected_ranges_m(robot: RobotFile) -> FloatArray | None:
    """What the sensors should say at the home angles; None when the robot has no sensors.

    Raises NotReady when the linkage cannot be assembled there.
    """
    if robot.sensors is None:
        return None
    home = Commands.of_angles(np.zeros(1), np.deg2rad([robot.homing.angle_deg]))
    ranges_m: FloatArray = Chain(robot).simulate(home).ranges[0]
    if not np.all(np.isfinite(ranges_m)):
        raise NotReady(
            "homing refused: the linkage cannot be assembled at homing.angle_deg"
            f" {robot.homing.angle_deg}; correct the robot file"
        )
    return ranges_m


BY_HAND = "put the arms against their stops and try again"


def check_plausible(
    robot: RobotFile,
    measured_m: FloatArray,
    accept_unseen_deg: float = 0.0,
    then: str = BY_HAND,
    simulated: bool = False,
) -> HomeSeen:
    """Compare good readings (NaN = none) with the home pose; returns what was seen.

    then: what to do when a sensor disagrees. simulated: nobody can look at the arms.

    Raises NotReady when a sensor disagrees by more than `homing.tolerance_m`, or when the good
    readings leave an arm undetermined by more than somebody has looked at and accepted.
    """
    expected_m = expected_ranges_m(robot)
    good = np.isfinite(measured_m) & (expected_m is not None)
    error_m = (
        np.zeros(len(AXES)) if expected_m is None else np.where(good, measured_m - expected_m, 0.0)
    )
    worst = int(np.argmax(np.abs(error_m)))
    if expected_m is not None and abs(error_m[worst]) > robot.homing.tolerance_m:
        raise NotReady(
            f"homing refused: sensor {AXES[worst]} reads {measured_m[worst]:.3f} m but"
            f" {expected_m[worst]:.3f} m is expected with the arms at"
            f" {robot.homing.angle_deg} degrees; {then}"
        )
    off_deg = _off_unseen_deg(robot, good, accept_unseen_deg)
    off_mm = abs(error_m[worst]) * 1e3
    agree = f"sensors agree with the home angles to {off_mm:.1f} mm"
    if robot.homing.method != "placed":
        return HomeSeen(f"each arm found its switch; {agree if good.any() else 'no sensor looks'}")
    blind = f"an arm that is less than {off_deg} degrees off"
    seen = f"{agree}; they would not notice {blind}" if good.any() else f"no sensor sees {blind}"
    if not simulated:
        seen += ", so look whether each arm is against its stop"
    warning_m = robot.homing.warning_m
    if off_mm <= warning_m * 1e3:
        return HomeSeen(seen)
    return HomeSeen(
        seen,
        f"sensor {AXES[worst]} is {off_mm:.1f} mm from where the arms were said to be placed"
        f" (homing.warning_m: {warning_m * 1e3:g} mm); look whether they are against their stops",
    )


def _off_unseen_deg(robot: RobotFile, good: BoolArray, accepted_deg: float) -> int:
    """How far an arm may be off unseen, rounded up. Raises NotReady unless seen or accepted.

    Switches determine each arm by itself; a robot that has them needs no sensors for that.
    """
    off_deg = unseen_deg(robot, good)
    if determine(robot, good) or off_deg <= accepted_deg:
        return off_deg
    if robot.homing.method == "switch" and robot.sensors is None:
        return off_deg
    missing = " and ".join(axis for axis, ok in zip(AXES, good, strict=True) if not ok)
    lack = f"no good reading from sensor {missing}" if robot.sensors else "the robot has no sensors"
    look = "see 'deltactl status sensors', or look" if robot.sensors else "look"
    raise NotReady(
        f"homing refused: {lack}, so that an arm could be off by {off_deg} degrees unseen;"
        f" {look} at the arms yourself and say 'deltactl home --accept-unseen {off_deg}'"
    )
