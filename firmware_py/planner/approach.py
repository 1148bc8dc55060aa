"""The way of the arms from where they are to a path's start: in joint space or straight in space.

Arms against upper stops are a special pose: on the Zhao robot all arms at -20 degrees lie
beyond their serial singularities, and the straight way down leads through the flat pose at
0 degrees (0.25 m + 0.25 m of reach are just the forearm's 0.5 m), where the arms do not hold
the platform at all. Passing a serial singularity is harmless when the arms lead, because
they still determine the platform; a parallel one is not. Moving one arm after another
passes the first kind only, with the parallel margin never below 0.43.

A straight way is planned when the move begins, because only then is it known where the arms are.
If they are outside the robot's limits, as at their stops after homing, no straight line
leads out: they go as to the start of any path, the platform no faster than asked either.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from deltactl.firmware_py.compensation.lead import lags_s
from deltactl.firmware_py.compensation.ringing import rings
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.paths import reach
from deltactl.firmware_py.paths.path import curve, line
from deltactl.firmware_py.planner.limits import ROUNDING_M, PathLimits
from deltactl.firmware_py.planner.motion import Schedule
from deltactl.firmware_py.planner.targets import Lap, LapBuilder
from deltactl.firmware_py.planner.timing_accelerated import CurveSchedule
from deltactl.firmware_py.planner.timing_moves import MotorLimits, MoveSchedule, TogetherSchedule
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import MotionError, UnreachablePoint
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.inverse_kinematics import InverseKinematics
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import ARMS, FloatArray

SLOWER = 0.95
"""Share of a platform's speed that is used: how fast arms move it is known every two degrees."""
STILL_TICKS = 1e-6
"""Less than this is rounding, not movement."""
GENTLE = 0.05
"""With this share of the acceleration a platform that rings is brought to its path, and arms whose
drives are led: what is added to lead them then stays within what they can follow."""


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
        acceleration_radps2=limits.joint_acceleration_radps2 * _share(robot),
        step_rate_hz=limits.step_rate_hz,
        rad_per_step=step_rad,
        tick_s=robot.tick_s,
    )
    fastest = SLOWER * speed_mps / np.maximum(steepest_m, 1e-12)
    return MoveSchedule(way_rad, np.zeros(len(way_rad)), motors, fastest)


def _share(robot: RobotFile) -> float:
    """Share of the acceleration that the way to a path may have."""
    return GENTLE if rings(robot) or lags_s(robot)[1].any() else 1.0


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
            f"the arms are at {_degrees(start_rad)} deg, where the linkage of '{robot.name}'"
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


SPACING_M = 0.001
"""Spacing of targets on the line; the arms' cubics stray from it by less than a micrometre."""
HERE_M = 1e-6
"""Nearer than this the platform is there already."""


@dataclass(frozen=True, slots=True, eq=False)
class WayIn:
    """The steps to the first target of a path; says: what is otherwise than was asked for."""

    schedule: Schedule
    says: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class StraightWay:
    """Lines to places, for one job of one robot."""

    job: JobFile
    robot: RobotFile
    kinematics: InverseKinematics
    motors: MotorLimits
    speed_mps: float

    def way(self, start_rad: FloatArray, there: Lap, preload_rad: FloatArray | None) -> WayIn:
        """From arm angles (3,) to the first target of a lap; preload_rad as in `approach`.

        Raises UnreachablePoint or LimitExceeded for the first bad place on the line.
        """
        goal_rad, goal_m = there.angles_rad[0], there.position_m[0]
        start = CalibratedInverse(self.robot).position_of_one_m(tuple(start_rad.tolist()))
        start_m = np.array(start)
        if np.linalg.norm(goal_m - start_m) < HERE_M:
            return self._by_arms(start_rad, goal_rad, preload_rad)
        if not self._begins_inside(start_rad, start_m):
            return self._by_arms(start_rad, goal_rad, preload_rad, told=True)
        end_rad = goal_rad if preload_rad is None else goal_rad - preload_rad
        lap = self._line(start_rad, end_rad, start_m, goal_m)
        rest, angles_rad, position_m = lap.rest, lap.angles_rad, lap.position_m
        if preload_rad is not None:
            at = forward(Linkage.of(self.robot.geometry), np.stack([end_rad, goal_rad])).position_m
            rest = np.append(rest, True)
            angles_rad = np.vstack([angles_rad, goal_rad])
            position_m = np.vstack([position_m, goal_m + at[1] - at[0]])
        if self.robot.steps.backend == "gpiozero":
            far_m = np.linalg.norm(np.diff(position_m, axis=0), axis=1)
            fastest_radps = self.motors.speed_radps
            return WayIn(all_together(self.robot, angles_rad, far_m, self.speed_mps, fastest_radps))
        schedule = CurveSchedule(
            angles_rad, position_m, rest, np.zeros(len(rest)), self.speed_mps, self._gentle()
        )
        PathLimits(self.job, self.robot).check_swing(*schedule.angle_range_rad())
        return WayIn(schedule)

    def _begins_inside(self, start_rad: FloatArray, start_m: FloatArray) -> bool:
        """Whether the robot may be where it is, and the inverse finds these arms there."""
        if not np.isfinite(start_m).all():
            return False
        lap, failed = self._builder().first(curve(start_m[None, :], SPACING_M))
        if failed is not None:
            return False
        off_deg = np.rad2deg(np.abs(start_rad - lap.angles_rad[0]).max())
        if off_deg > self.robot.limits.network_deg:  # its elbows are turned the other way
            return False
        try:
            PathLimits(self.job, self.robot).check(lap, None, 1)
        except MotionError:
            return False
        return True

    def _line(
        self, start_rad: FloatArray, end_rad: FloatArray, start_m: FloatArray, goal_m: FloatArray
    ) -> Lap:
        """The line as a lap, checked; its ends are exactly these angles."""
        path = curve(line(start_m, goal_m, SPACING_M), SPACING_M)
        lap, failed = self._builder().first(path)
        if failed is None:
            # What whole steps and play leave at both ends is spread over the line.
            part = np.linspace(0.0, 1.0, len(lap))[:, None]
            first, last = start_rad - lap.angles_rad[0], end_rad - lap.angles_rad[-1]
            angles_rad = lap.angles_rad + (1.0 - part) * first + part * last
            counts = np.rint(angles_rad / self.robot.drive.rad_per_step).astype(np.int64)
            lap = replace(lap, angles_rad=angles_rad, counts=counts)
        try:
            PathLimits(self.job, self.robot).check(lap, failed, 1)
        except MotionError as error:
            if (wrong := error.at_point) is None:
                raise
            where = " ".join(f"{1e3 * value:.6g}" for value in goal_m)
            raise error.at(
                f"{self.job.name}: straight on the way to {where} mm: ",
                replace(wrong, on_the_way=True),
            ) from error
        return lap

    def _by_arms(
        self,
        start_rad: FloatArray,
        goal_rad: FloatArray,
        preload_rad: FloatArray | None,
        told: bool = False,
    ) -> WayIn:
        says = (
            "no straight line leads out of where the arms stood (beyond the robot's limits, as at"
            f" home); they took another way, the platform no faster than {1e3 * self.speed_mps:g}"
            " mm/s"
        )
        schedule = approach(self.robot, start_rad, goal_rad, preload_rad, self.speed_mps)
        return WayIn(schedule, says if told else "")

    def _builder(self) -> LapBuilder:
        linkage = Linkage.of(self.robot.geometry)
        return LapBuilder(self.kinematics, linkage, self.robot.drive.rad_per_step)

    def _gentle(self) -> MotorLimits:
        share = _share(self.robot)
        return replace(self.motors, acceleration_radps2=share * self.motors.acceleration_radps2)
