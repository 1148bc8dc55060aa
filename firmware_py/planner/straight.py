"""The way to a place, straight in space from wherever the platform is, no faster than asked.

It is planned when the move begins, because only then is it known where the arms are. Where they
stand outside the robot's limits, as against their stops after homing, no line in space leads
out: they go as to the start of any path, the platform no faster than asked either.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from deltactl.firmware_py.compensation.ringing import rings
from deltactl.firmware_py.job_file import JobFile
from deltactl.firmware_py.paths.path import curve, line
from deltactl.firmware_py.planner.approach import GENTLE, all_together, approach
from deltactl.firmware_py.planner.limits import PathLimits
from deltactl.firmware_py.planner.motion import Schedule
from deltactl.firmware_py.planner.targets import Lap, LapBuilder
from deltactl.firmware_py.planner.timing_accelerated import CurveSchedule
from deltactl.firmware_py.planner.timing_moves import MotorLimits
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import MotionError
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.inverse_kinematics import InverseKinematics
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import FloatArray

SPACING_M = 0.001
"""Of targets on the line. The arms' cubics between them stray from it by less than a micrometre."""
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
        share = GENTLE if rings(self.robot) else 1.0
        return replace(self.motors, acceleration_radps2=share * self.motors.acceleration_radps2)
