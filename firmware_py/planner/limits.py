"""Everything a path is checked for before anything moves; the first bad point is named."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from deltactl.firmware_py.job_file import Accelerated, JobFile, Together, way_in_mps
from deltactl.firmware_py.paths import reach
from deltactl.firmware_py.paths.path import BoolArray, Space
from deltactl.firmware_py.paths.reach import Reach
from deltactl.firmware_py.planner.targets import Lap, MappingFailed, in_repeat
from deltactl.firmware_py.robot_file import Limits, RobotFile
from deltactl.foundation.errors import (
    ELSEWHERE,
    LimitExceeded,
    MotionError,
    Refusal,
    UnreachablePoint,
)
from deltactl.models.inverse_kinematics import USE_GEOMETRY
from deltactl.models.linkage import Linkage, Status, inverse
from deltactl.models.robot import AXES, FloatArray

ROUNDING_M = 1e-9


@dataclass(frozen=True, slots=True)
class Problem:
    """A broken limit at a point of a lap, or (half numbers) on the way to the next one."""

    row: float
    error: type[MotionError]
    why: str
    remedy: str = ELSEWHERE


class PathLimits:
    """The limits of one robot, held against laps and timings."""

    def __init__(self, job: JobFile, robot: RobotFile):
        self._job = job
        self._robot = robot
        self._limits: Limits = robot.limits
        self._linkage = Linkage.of(robot.geometry)

    def check(
        self, lap: Lap, failed: MappingFailed | None, repeat: int
    ) -> tuple[Reach, FloatArray]:
        """What happens on the moves of a lap, and the margins at its targets.

        Raises UnreachablePoint or LimitExceeded for the first bad point.
        """
        problems = [
            *self._arm_problems(lap),
            *self._box_problems(lap),
            *self._geometry_problems(lap),
        ]
        # Past a bad point angles may be anything, and moves between them endless.
        good = min((round(problem.row) for problem in problems), default=len(lap))
        reached = reach.moves(self._linkage, lap.angles_rad[:good])
        margins = reach.poses(self._linkage, lap.angles_rad[:good]).margin
        problems += self._margin_problems(reached, margins)
        problems += self._way_problems(lap, reached)
        first = min(problems, key=lambda problem: problem.row, default=None)
        if first is not None:
            raise self._refused(lap, first, repeat)
        if failed is not None:
            number = f"{self._job.name}: point {len(lap)}{in_repeat(repeat, self._job.repeats)}: "
            told = failed.error.worded(number + str(failed.error))
            if told.at_point is not None and repeat == 1:
                told.at_point = replace(told.at_point, point=len(lap))
            raise told from failed.error
        return reached, margins

    def check_swing(self, low_rad: FloatArray, high_rad: FloatArray) -> None:
        """Angles reached between targets, (3,), by swinging through them without a stop."""
        low_deg, high_deg = self._limits.arm_deg
        slack_rad = self._robot.drive.rad_per_step
        low = low_rad < np.deg2rad(low_deg) - slack_rad
        high = high_rad > np.deg2rad(high_deg) + slack_rad
        for arm in first_true(low | high):
            raise LimitExceeded(
                f"{self._job.name}: between two points arm {arm + 1} would swing to"
                f" {np.rad2deg(low_rad[arm] if low[arm] else high_rad[arm]):.2f} deg, outside its"
                f" limits of {low_deg:g} to {high_deg:g} deg; make spacing_m smaller"
            )

    def _refused(self, lap: Lap, problem: Problem, repeat: int) -> MotionError:
        row = int(np.ceil(problem.row))
        number = int(lap.number[row])
        point = number if number >= 0 else None
        refusal = Refusal(problem.why, problem.remedy, row != problem.row, point)
        way = "on the way to " if refusal.on_the_way else ""
        named = lap.says(row) + in_repeat(repeat, self._job.repeats)
        where = f"{self._job.name}: {way}{named}: "
        return problem.error.at(where, refusal)

    def _arm_problems(self, lap: Lap) -> Iterator[Problem]:
        low_deg, high_deg = self._limits.arm_deg
        step_rad = self._robot.drive.rad_per_step
        # A limit falls on the nearest whole step, as in models.inverse_kinematics.TargetMapper.
        low, high = (round(np.deg2rad(angle) / step_rad) for angle in self._limits.arm_deg)
        outside = (lap.counts < low) | (lap.counts > high)
        for row in first_true(outside.any(axis=1)):
            arm = int(np.argmax(outside[row]))
            angle_deg = np.rad2deg(lap.angles_rad[row, arm])
            yield Problem(
                row,
                LimitExceeded,
                f"arm {arm + 1} would be at {angle_deg:.2f} deg, outside its limits of"
                f" {low_deg:g} to {high_deg:g} deg (limits.arm_deg, or its default)",
            )

    def _box_problems(self, lap: Lap) -> Iterator[Problem]:
        for axis, (low_m, high_m) in enumerate(self._limits.box_m or ()):
            at_m = lap.position_m[:, axis]
            for row in first_true((at_m < low_m - ROUNDING_M) | (at_m > high_m + ROUNDING_M)):
                yield _leaves_box(row, axis, low_m, high_m)

    def _way_problems(self, lap: Lap, reached: Reach) -> Iterator[Problem]:
        if lap.space is Space.CARTESIAN:
            return
        for axis, (low_m, high_m) in enumerate(self._limits.box_m or ()):
            for row in first_true(
                (reached.low_m[:, axis] < low_m - ROUNDING_M)
                | (reached.high_m[:, axis] > high_m + ROUNDING_M)
            ):
                yield _leaves_box(row + 0.5, axis, low_m, high_m)

    def _geometry_problems(self, lap: Lap) -> Iterator[Problem]:
        """A broken network must not send the arms astray: geometry has to agree roughly."""
        if lap.space is Space.JOINT or not len(lap):
            return
        geometric = inverse(self._linkage, lap.targets)
        for row in first_true(geometric.status != Status.OK):
            yield Problem(row, UnreachablePoint, "out of reach by the robot file's geometry")
        apart = np.abs(lap.angles_rad - geometric.angles_rad)
        bound_deg = self._limits.network_deg
        with np.errstate(invalid="ignore"):
            astray = (apart > np.deg2rad(bound_deg)).any(axis=1)
        for row in first_true(astray):
            arm = int(np.argmax(apart[row]))
            yield Problem(
                row,
                LimitExceeded,
                f"the inverse kinematics puts arm {arm + 1} {np.rad2deg(apart[row, arm]):.1f} deg"
                f" from where the geometry has it, more than limits.network_deg {bound_deg:g}",
                f"train the network again, or {USE_GEOMETRY}; if the"
                " robot is built that far from its file, name a calibrated robot file in the job"
                " (deltactl network evaluate --save-robot)",
            )

    def _margin_problems(self, reached: Reach, margins: FloatArray) -> Iterator[Problem]:
        limit = self._limits.singularity_margin
        for row in first_true(margins < limit):
            yield _margin_problem(row, margins[row], limit)
        for row in first_true(reached.margin < limit):
            yield _margin_problem(row + 0.5, reached.margin[row], limit)

    def check_timing(self) -> None:
        """Raises LimitExceeded when the job asks for more than the robot's speed limits."""
        timing, limits = self._job.timing, self._limits
        self._check_backend()
        if isinstance(timing, Together):
            rate_hz = 1.0 / timing.t_pwm_s
            speed_radps = rate_hz * self._robot.drive.rad_per_step
            self._at_most(
                rate_hz, limits.step_rate_hz, f"t_pwm_s {timing.t_pwm_s:g}", "step_rate_hz", "Hz"
            )
            self._at_most(
                speed_radps,
                limits.joint_speed_radps,
                f"t_pwm_s {timing.t_pwm_s:g}",
                "joint_speed_radps",
                "rad/s",
            )
            return
        for name, unit in (("joint_speed_radps", "rad/s"), ("joint_acceleration_radps2", "rad/s2")):
            asked = getattr(timing, name)
            if asked is not None:
                self._at_most(asked, getattr(limits, name), f"timing.{name}", name, unit)

    def _check_backend(self) -> None:
        timing, steps = self._job.timing, self._robot.steps
        if isinstance(timing, Together):
            if timing.t_pwm_s < steps.shortest_period_s * (1.0 - 1e-9):
                raise LimitExceeded(
                    f"{self._job.name}: t_pwm_s {timing.t_pwm_s:g} is shorter than the"
                    f" {steps.shortest_period_s:g} s that steps.backend {steps.backend} takes;"
                    " use a longer one, or the pulse backend in the robot file"
                )
        elif steps.backend == "gpiozero" and way_in_mps(self._job) is None:
            raise LimitExceeded(
                f"{self._job.name}: accelerated timing steps motors one shortly after the other,"
                " which steps.backend gpiozero cannot; use timing mode together, or the pulse"
                " backend in the robot file"
            )

    def _at_most(self, value: float, limit: float, what: str, name: str, unit: str) -> None:
        if value > limit * (1.0 + 1e-9):
            raise LimitExceeded(
                f"{self._job.name}: {what} means {value:.6g} {unit}, above the robot's"
                f" limits.{name} of {limit:g} {unit}; slow the job down"
            )


def joint_limits(robot: RobotFile, timing: Accelerated | Together) -> tuple[float, float]:
    """Joint speed [rad/s] and acceleration [rad/s^2] that hold for a job."""
    limits = robot.limits
    speed, acceleration = limits.joint_speed_radps, limits.joint_acceleration_radps2
    if isinstance(timing, Accelerated):
        speed = timing.joint_speed_radps or speed
        acceleration = timing.joint_acceleration_radps2 or acceleration
    return speed, acceleration


def first_true(mask: BoolArray) -> list[int]:
    """Index of the first True as a list of one, or an empty list."""
    return [int(np.argmax(mask))] if mask.any() else []


def _leaves_box(row: float, axis: int, low_m: float, high_m: float) -> Problem:
    why = f"{AXES[axis]} leaves limits.box_m [{low_m:g}, {high_m:g}] m"
    return Problem(row, LimitExceeded, why, "move the path inside")


def _margin_problem(row: float, margin: float, limit: float) -> Problem:
    if margin < 0.0:
        why = "the linkage cannot be assembled there or its elbow turns inside out"
    else:
        why = (
            f"the linkage is too near to singular (margin {margin:.3f},"
            f" limits.singularity_margin {limit:g})"
        )
    return Problem(row, UnreachablePoint, why)
