"""A checked job: laps with their timing, ready to be streamed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.job_file import JobFile, Together
from deltactl.firmware_py.job_timing import SLOWEST_MPS
from deltactl.firmware_py.paths.path import Space
from deltactl.firmware_py.paths.reach import Reach
from deltactl.firmware_py.planner.approach import StraightWay, WayIn, approach
from deltactl.firmware_py.planner.limits import joint_limits
from deltactl.firmware_py.planner.motion import Schedule
from deltactl.firmware_py.planner.targets import Lap
from deltactl.firmware_py.planner.timing_accelerated import CurveSchedule, timed_in
from deltactl.firmware_py.planner.timing_moves import MotorLimits, MoveSchedule, TogetherSchedule
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.inverse_kinematics import InverseKinematics
from deltactl.models.robot import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class TimedLap:
    """A lap, when its steps are due, and what was seen when it was checked."""

    lap: Lap
    schedule: Schedule
    reach: Reach
    margins: FloatArray

    @property
    def length_m(self) -> float:
        """How far the platform travels [m]."""
        if self.lap.space is Space.JOINT:
            return float(self.reach.length_m.sum())
        return self.lap.length_m


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A job that may run: every limit holds along the whole of it."""

    job: JobFile
    robot: RobotFile
    kinematics: InverseKinematics
    first: TimedLap
    again: TimedLap | None
    """The lap of every repeat but the first; None when there is only one."""
    first_dwell_s: float
    """Rest at the first target, before the first lap."""
    preload_rad: FloatArray | None = None
    """How far before the start of the path the way to it begins, (3,): play is taken up then."""
    way_in_mps: float | None = None
    """Speed of the way to the first target, where there is no other path."""

    def laps(self) -> Iterator[tuple[int, TimedLap]]:
        """The laps with their repeat, from 1."""
        yield 1, self.first
        for repeat in range(2, self.job.repeats + 1):
            assert self.again is not None
            yield repeat, self.again

    def way_in(self, from_counts: Counts) -> WayIn:
        """The moves from where the arms are to the first target.

        Raises UnreachablePoint, or LimitExceeded on a way that is to be straight.
        """
        start_rad = np.array(from_counts) * self.robot.drive.rad_per_step
        goal_rad, speed_mps = self.first.lap.angles_rad[0], self.way_in_mps
        if speed_mps is None:
            return WayIn(approach(self.robot, start_rad, goal_rad, self.preload_rad))
        motors = motor_limits(self.job, self.robot)
        if self.first.lap.space is Space.JOINT:
            fastest = motors.speed_radps
            return WayIn(approach(self.robot, start_rad, goal_rad, None, speed_mps, fastest))
        straight = StraightWay(self.job, self.robot, self.kinematics, motors, speed_mps)
        return straight.way(start_rad, self.first.lap, self.preload_rad)

    @property
    def last_counts(self) -> Counts:
        """Where the arms are when the job is done."""
        return _counts((self.again or self.first).lap, -1)

    @property
    def jump_hz(self) -> float:
        """By so much step rates may change at once: stepping together has full speed or none."""
        if isinstance(self.job.timing, Together):
            return 2.0 / self.job.timing.t_pwm_s
        return 2.0 / self.robot.steps.shortest_period_s if self._all_together else 0.0

    @property
    def _all_together(self) -> bool:
        """Whether all motors step at the same ticks, without ramps."""
        return isinstance(self.job.timing, Together) or self.robot.steps.backend == "gpiozero"

    @property
    def ramp_s(self) -> float:
        """Shortest time in which pausing may bring the motion from full speed to rest.

        Pausing adds speed / time to the accelerations planned, and must fit into what the plan
        leaves of the limit. Stepping together has no acceleration to respect.
        """
        limits = motor_limits(self.job, self.robot)
        spare = limits.acceleration_radps2 - limits.planned_acceleration_radps2
        if self._all_together:
            return TOGETHER_RAMP_S
        laps = [self.first] if self.again is None else [self.first, self.again]
        peak_hz = max(float(timed.schedule.peak_rate_hz.max()) for timed in laps)
        speed_radps = max(peak_hz * limits.rad_per_step, self.robot.limits.approach_speed_radps)
        if self.way_in_mps is not None:
            speed_radps = max(speed_radps, limits.planned_speed_radps)
        return max(TOGETHER_RAMP_S, speed_radps / spare)


TOGETHER_RAMP_S = 0.2


def schedule_of(job: JobFile, robot: RobotFile, lap: Lap, reach: Reach) -> Schedule:
    """The timing of a checked lap."""
    timing = job.timing
    if isinstance(timing, Together):
        return TogetherSchedule(lap.counts, lap.dwell_s, timing.t_pwm_s)
    at_speed = partial(_at_speed, motor_limits(job, robot), lap, reach)
    if timing.duration_s is not None:
        known = lap.space is Space.CARTESIAN
        mean_mps = lap.length_m / timing.duration_s if known else SLOWEST_MPS
        return timed_in(timing.duration_s, at_speed, mean_mps)
    assert timing.speed_mps is not None
    return at_speed(timing.speed_mps)


def _at_speed(limits: MotorLimits, lap: Lap, reach: Reach, job_mps: float) -> Schedule:
    """The timing of a lap at this speed of the platform, or below it where limits ask for it."""
    if lap.space is Space.CARTESIAN and len(lap) > 1:
        speed_mps: float | FloatArray = job_mps
        if lap.speed_mps is not None:
            speed_mps = np.minimum(job_mps, lap.speed_mps[1:])
        return CurveSchedule(
            lap.angles_rad, lap.position_m, lap.rest, lap.dwell_s, speed_mps, limits
        )
    with np.errstate(divide="ignore"):
        fastest = job_mps / reach.steepest_m
    return MoveSchedule(lap.angles_rad, lap.dwell_s, limits, fastest)


def motor_limits(job: JobFile, robot: RobotFile) -> MotorLimits:
    """What holds for every motor in a job."""
    speed_radps, acceleration_radps2 = joint_limits(robot, job.timing)
    return MotorLimits(
        speed_radps=speed_radps,
        acceleration_radps2=acceleration_radps2,
        step_rate_hz=robot.limits.step_rate_hz,
        rad_per_step=robot.drive.rad_per_step,
        tick_s=robot.tick_s,
    )


def _counts(lap: Lap, row: int) -> Counts:
    first, second, third = lap.counts[row].tolist()
    return first, second, third
