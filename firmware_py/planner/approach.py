"""The way of the arms from where they are to where a path starts, in joint space.

Arms against upper stops are a special pose: on the Zhao robot all arms at -20 degrees lie
beyond their serial singularities, and the straight way down leads through the flat pose at
0 degrees (0.25 m + 0.25 m of reach are just the forearm's 0.5 m), where the arms do not hold
the platform at all. Passing a serial singularity is harmless when the arms lead, because
they still determine the platform; a parallel one is not. Moving one arm after another
passes the first kind only, with the parallel margin never below 0.43.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from deltactl.firmware_py.compensation.ringing import rings
from deltactl.firmware_py.paths import reach
from deltactl.firmware_py.planner.limits import ROUNDING_M
from deltactl.firmware_py.planner.timing_moves import MotorLimits, MoveSchedule
from deltactl.firmware_py.planner.timing_together import TogetherSchedule
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import UnreachablePoint
from deltactl.models.linkage import Linkage
from deltactl.models.robot import ARMS, FloatArray

SLOWER = 0.95
"""Share of a platform's speed that is used: how fast arms move it is known every two degrees."""
STILL_TICKS = 1e-6
"""Less than this is rounding, not movement."""
GENTLE = 0.05
"""A platform that rings is brought to its path with this share of the acceleration."""


def approach(
    robot: RobotFile,
    start_rad: FloatArray,
    goal_rad: FloatArray,
    preload_rad: FloatArray | None = None,
    speed_mps: float = math.inf,
    speed_radps: float | None = None,
) -> MoveSchedule | TogetherSchedule:
    """Moves from one pose to another; angles (3,), commanded.

    preload_rad: the last of the way comes from so far beside the goal, (3,) [rad]. speed_mps: the
    platform is no faster; speed_radps: no arm is, `limits.approach_speed_radps` where it is absent.
    Where the backend cannot step motors one shortly after the other, all step together.

    Raises UnreachablePoint when no way is found.
    """
    limits, step_rad = robot.limits, robot.drive.rad_per_step
    if preload_rad is None:
        way_rad = find_way(robot, start_rad, goal_rad)
    else:
        way_rad = np.vstack([find_way(robot, start_rad, goal_rad - preload_rad), goal_rad])
    asked_radps = limits.approach_speed_radps if speed_radps is None else speed_radps
    steepest_m = np.zeros(len(way_rad) - 1)
    if math.isfinite(speed_mps):
        steepest_m = reach.moves(Linkage.of(robot.geometry), way_rad).steepest_m
    if robot.steps.backend == "gpiozero":
        return all_together(robot, way_rad, steepest_m / SLOWER, speed_mps, asked_radps)
    motors = MotorLimits(
        speed_radps=min(asked_radps, limits.joint_speed_radps),
        acceleration_radps2=limits.joint_acceleration_radps2 * (GENTLE if rings(robot) else 1.0),
        step_rate_hz=limits.step_rate_hz,
        rad_per_step=step_rad,
        tick_s=robot.tick_s,
    )
    fastest = SLOWER * speed_mps / np.maximum(steepest_m, 1e-12)
    return MoveSchedule(way_rad, np.zeros(len(way_rad)), motors, fastest)


def all_together(
    robot: RobotFile, way_rad: FloatArray, far_m: FloatArray, speed_mps: float, speed_radps: float
) -> TogetherSchedule:
    """All motors at the same ticks along arm angles (n, 3), at the shortest period that will do.

    far_m: how far the platform goes between them, (n - 1,); it is no faster than speed_mps, and no
    arm than speed_radps.
    """
    limits, step_rad = robot.limits, robot.drive.rad_per_step
    counts = np.rint(way_rad / step_rad).astype(np.int64)
    ticks = np.abs(np.diff(way_rad, axis=0)).max(axis=1) / step_rad
    far_m, ticks = far_m[ticks > STILL_TICKS], ticks[ticks > STILL_TICKS]
    period_s = max(
        robot.steps.shortest_period_s,
        1.0 / limits.step_rate_hz,
        step_rad / min(speed_radps, limits.joint_speed_radps),
        float((far_m / ticks).max(initial=0.0)) / speed_mps,
    )
    return TogetherSchedule(counts, np.zeros(len(way_rad)), period_s)


def find_way(robot: RobotFile, start_rad: FloatArray, goal_rad: FloatArray) -> FloatArray:
    """Arm angles (k, 3) to move through, each stretch straight in joint space.

    The straight way if it keeps to `limits.singularity_margin`, else the safest of a few. Where
    an end itself lies beyond a serial singularity only the parallel margin is asked for.
    Raises UnreachablePoint when no way will do.
    """
    linkage = Linkage.of(robot.geometry)
    ends = reach.poses(linkage, np.stack([start_rad, goal_rad]))
    if ends.parallel[0] < 0.0:
        raise UnreachablePoint(
            f"the arms stand at {_degrees(start_rad)} deg, where the linkage of '{robot.name}'"
            " cannot be assembled; check homing.angle_deg and the lengths in the robot file"
        )
    limit = robot.limits.singularity_margin
    inside_out = bool((ends.serial < limit).any())
    best, best_margin = None, min(limit, float(ends.margin.min()))
    if inside_out:
        best_margin = min(limit, float(ends.parallel.min()))
    for way in _ways(start_rad, goal_rad):
        seen = reach.moves(linkage, way)
        margin = float((seen.parallel if inside_out else seen.margin).min())
        if margin < best_margin or not _stays_in_box(robot, ends.position_m[0], seen):
            continue
        if not inside_out:
            return way
        best, best_margin = way, margin * (1.0 + 1e-9)
    if best is None:
        raise UnreachablePoint(
            f"no way of the arms from {_degrees(start_rad)} deg to {_degrees(goal_rad)} deg keeps"
            f" within limits.singularity_margin and limits.box_m of '{robot.name}';"
            " go there by a job with points on the way"
        )
    return best


def _ways(start_rad: FloatArray, goal_rad: FloatArray) -> Iterator[FloatArray]:
    """Straight, by poses with all arms alike (the safest a delta has), and arm after arm."""
    yield np.stack([start_rad, goal_rad])
    alike_start = np.full_like(start_rad, start_rad.mean())
    alike_goal = np.full_like(goal_rad, goal_rad.mean())
    yield np.stack([start_rad, alike_goal, goal_rad])
    yield np.stack([start_rad, alike_start, goal_rad])
    yield np.stack([start_rad, alike_start, alike_goal, goal_rad])
    for order in itertools.permutations(range(ARMS)):
        way = [start_rad]
        for arm in order:
            way.append(np.where(np.arange(ARMS) == arm, goal_rad, way[-1]))
        yield np.stack(way)


def _stays_in_box(robot: RobotFile, start_m: FloatArray, seen: reach.Reach) -> bool:
    """Whether the way keeps to the box; one that begins outside (at home) need not."""
    if robot.limits.box_m is None:
        return True
    low_m, high_m = np.array(robot.limits.box_m).T
    low_m, high_m = low_m - ROUNDING_M, high_m + ROUNDING_M
    if (start_m < low_m).any() or (start_m > high_m).any():
        return True
    return bool(((seen.low_m >= low_m) & (seen.high_m <= high_m)).all())


def _degrees(angles_rad: FloatArray) -> str:
    return "(" + ", ".join(f"{angle:.1f}" for angle in np.rad2deg(angles_rad)) + ")"
