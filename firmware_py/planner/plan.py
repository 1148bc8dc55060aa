"""A job with one path, checked and ready to be streamed, also for a robot that remembers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.compensation.hanging import Pace
from deltactl.firmware_py.compensation.lead import stretch
from deltactl.firmware_py.compensation.remembering import Course, Remembering
from deltactl.firmware_py.job_file import SLOWEST_MPS, JobFile, Together, load_job, way_in_mps
from deltactl.firmware_py.job_targets import kinematics_of, path_of
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.paths.path import Space
from deltactl.firmware_py.paths.reach import Reach
from deltactl.firmware_py.planner.approach import StraightWay, WayIn, approach
from deltactl.firmware_py.planner.limits import PathLimits, joint_limits
from deltactl.firmware_py.planner.motion import Schedule
from deltactl.firmware_py.planner.targets import Lap, LapBuilder, MappingFailed
from deltactl.firmware_py.planner.timing_accelerated import CurveSchedule, timed_in
from deltactl.firmware_py.planner.timing_moves import MotorLimits, MoveSchedule, TogetherSchedule
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.clock import NS_PER_S
from deltactl.foundation.errors import ConfigError
from deltactl.models.inverse_kinematics import InverseKinematics
from deltactl.models.linkage import Linkage
from deltactl.models.robot import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class TimedLap:
    """A lap, when its steps are due, and what was seen when it was checked."""

    lap: Lap
    schedule: Schedule
    reach: Reach
    margins: FloatArray
    led: float = 1.0
    """How many times as long it takes as asked for, so that late drives can be led along it."""

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
    def timed(self) -> list[TimedLap]:
        """The first lap, and that of every other repeat where there is one."""
        return [self.first] if self.again is None else [self.first, self.again]

    @property
    def last_counts(self) -> Counts:
        """Where the arms are when the job is done."""
        first, second, third = (self.again or self.first).lap.counts[-1].tolist()
        return first, second, third

    @property
    def jump_hz(self) -> float:
        """By so much step rates may change at once: stepping together has full speed or none."""
        if isinstance(self.job.timing, Together):
            return _jump_hz(self.job) / min(timed.led for timed in self.timed)
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
        peak_hz = max(float(timed.schedule.peak_rate_hz.max()) for timed in self.timed)
        speed_radps = max(peak_hz * limits.rad_per_step, self.robot.limits.approach_speed_radps)
        if self.way_in_mps is not None:
            speed_radps = max(speed_radps, limits.planned_speed_radps)
        return max(TOGETHER_RAMP_S, speed_radps / spare)


def _jump_hz(job: JobFile) -> float:
    """As it was asked for: 0 for a timing with ramps."""
    return 2.0 / job.timing.t_pwm_s if isinstance(job.timing, Together) else 0.0


TOGETHER_RAMP_S = 0.2


def schedule_of(
    job: JobFile, robot: RobotFile, lap: Lap, reach: Reach, stretched: float = 1.0
) -> Schedule:
    """The timing of a checked lap; stretched: so many times as slow as was asked for."""
    timing = job.timing
    if isinstance(timing, Together):
        return TogetherSchedule(lap.counts, lap.dwell_s, stretched * timing.t_pwm_s)
    at_speed = partial(_at_speed, motor_limits(job, robot), lap, reach)
    if timing.duration_s is not None:
        known = lap.space is Space.CARTESIAN
        mean_mps = lap.length_m / timing.duration_s if known else SLOWEST_MPS
        return timed_in(stretched * timing.duration_s, at_speed, mean_mps)
    assert timing.speed_mps is not None
    return at_speed(timing.speed_mps / stretched)


def _led_schedule(job: JobFile, robot: RobotFile, lap: Lap, reach: Reach) -> tuple[Schedule, float]:
    """The timing, slowed where a drive that follows late could not be led, and by how much."""
    stretched, schedule = 1.0, schedule_of(job, robot, lap, reach)
    if lap.space is Space.JOINT or len(lap) < 2:
        return schedule, stretched
    jump_hz = _jump_hz(job)
    for _ in range(MOST_STRETCHED):
        arrives_s, rests_s = schedule.reached_ns / NS_PER_S, lap.dwell_s
        t_s = np.stack([arrives_s, arrives_s + rests_s], axis=1).ravel()
        more = stretch(robot, t_s, np.repeat(lap.angles_rad, 2, axis=0), jump_hz / stretched)
        if more <= 1.0:
            break
        stretched *= max(more, LEAST_STRETCHED)
        schedule = schedule_of(job, robot, lap, reach, stretched)
    return schedule, stretched


MOST_STRETCHED, LEAST_STRETCHED = 8, 1.02
"""So often, and by at least so much, is a path slowed until its drives can be led."""


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


USUAL_START_S = 3.0
"""From switching the drives on to the start of a path, for what changes as the arms warm up."""


class LapMemory:
    """Commands the first and every later lap of one plan."""

    def __init__(self, job: JobFile, robot: RobotFile, remembering: Remembering):
        self._job, self._robot, self._remembering = job, robot, remembering
        self._first: TimedLap | None = None
        """The first lap as it was mapped and timed."""
        self._again: TimedLap | None = None

    def first(self, timed: TimedLap) -> Lap:
        """The first lap; the way to it takes play up in the direction it will set out in."""
        self._first = self._first or timed
        mapped = Course(_times_s(timed), self._first.lap.angles_rad, self._pace(self._first, timed))
        before = self._remembering.before(mapped)
        return self._commanded(timed.lap, self._remembering.angles_rad(mapped, before))

    def again(self, timed: TimedLap, first: TimedLap) -> Lap:
        """Every later lap: it begins where the one before ended, and ends there too.

        Growth is followed up to the second lap; what little is left of it later is not.
        """
        self._again = self._again or timed
        earlier = Course(_times_s(first), first.lap.angles_rad)
        begins_s = float(earlier.t_s[-1]) + float(first.lap.dwell_s[-1])
        times_s = begins_s + _times_s(timed) - USUAL_START_S
        mapped = Course(times_s, self._again.lap.angles_rad, self._pace(self._again, timed))
        commanded = self._remembering.angles_rad(mapped, earlier)
        commanded[0] = commanded[-1] = first.lap.angles_rad[-1]
        return self._commanded(timed.lap, commanded)

    def preload_rad(self) -> FloatArray | None:
        """How far before the start of the path the way to it begins, (3,) [rad].

        As the arms are meant to set out, which is what the first lap was worked out for: where an
        arm turns round within a step of the start, what is commanded may set out the other way.
        """
        if self._first is None:
            return None
        preload = self._remembering.preload_rad(self._first.lap.angles_rad)
        return preload if preload.any() else None

    def _pace(self, mapped: TimedLap, timed: TimedLap) -> Pace:
        """That of a lap before play is taken up, as slow as its drives are led now."""
        limits, t_s = motor_limits(self._job, self._robot), mapped.schedule.reached_ns / NS_PER_S
        speed_radps = limits.speed_radps
        if isinstance(self._job.timing, Together):
            speed_radps = limits.rad_per_step / (timed.led * self._job.timing.t_pwm_s)
        t_s = timed.led / mapped.led * t_s
        return Pace(t_s, speed_radps, limits.acceleration_radps2, mapped is self._first)

    def _commanded(self, lap: Lap, angles_rad: FloatArray) -> Lap:
        counts = np.rint(angles_rad / self._robot.drive.rad_per_step).astype(np.int64)
        return replace(lap, angles_rad=angles_rad, counts=counts, mapped=lap.mapped_counts)


def _times_s(timed: TimedLap) -> FloatArray:
    times: FloatArray = USUAL_START_S + timed.schedule.reached_ns / NS_PER_S
    return times


def home_counts(robot: RobotFile) -> Counts:
    """Counts of the home angles: where the arms are after homing."""
    first, second, third = (
        round(math.radians(angle) / robot.drive.rad_per_step) for angle in robot.homing.angle_deg
    )
    return first, second, third


def make_plan(job: JobFile, robot: RobotFile, kinematics: InverseKinematics) -> Plan:
    """Check the whole path of a job, all repeats, and time it.

    Raises UnreachablePoint or LimitExceeded, naming the first bad point, and ConfigError.
    """
    limits = PathLimits(job, robot)
    limits.check_timing()
    path = path_of(job, robot)
    remembering = Remembering(robot)
    if remembering.active and path.space is Space.CARTESIAN:
        return _with_memory(job, robot, kinematics, remembering)
    builder = LapBuilder(kinematics, Linkage.of(robot.geometry), robot.drive.rad_per_step)
    first = _timed(job, robot, limits, builder.first(path), 1)
    again = None
    if job.repeats > 1:
        # A closed path is the same every time round.
        again = first if path.is_closed else _timed(job, robot, limits, builder.again(path), 2)
    rest_s = float(path.dwell_s[0])
    return Plan(job, robot, kinematics, first, again, rest_s, way_in_mps=way_in_mps(job))


def _with_memory(
    job: JobFile, robot: RobotFile, kinematics: InverseKinematics, remembering: Remembering
) -> Plan:
    """The same where arms have play or grow: laps are planned, then commanded otherwise."""
    limits, path = PathLimits(job, robot), path_of(job, robot)
    builder = LapBuilder(kinematics, Linkage.of(robot.geometry), robot.drive.rad_per_step)
    memory = LapMemory(job, robot, remembering)
    first = _timed(job, robot, limits, builder.first(path), 1)
    for _ in range(TIMED_AGAIN):
        first = _timed(job, robot, limits, (memory.first(first), None), 1)
    again = None
    if job.repeats > 1:
        built = builder.first(path) if path.is_closed else builder.again(path)
        again = _timed(job, robot, limits, built, 2)
        for _ in range(TIMED_AGAIN):
            again = _timed(job, robot, limits, (memory.again(again, first), None), 2)
    rest_s, preload_rad = float(path.dwell_s[0]), memory.preload_rad()
    return Plan(job, robot, kinematics, first, again, rest_s, preload_rad, way_in_mps(job))


TIMED_AGAIN = 2
"""Taking up play changes the timing, and where arms fall slowly in their play that changes it."""


def plan_of(job_path: Path, robot: RobotFile | None = None) -> Plan:
    """The plan of a job file, for the robot it names or for one that is there already.

    Raises ConfigError for a job of steps, which has a plan for each of its moves.
    """
    job = load_job(job_path)
    if job.path is None:
        raise ConfigError(f"{job_path}: has steps, and a job with one path is needed here")
    if robot is None:
        robot = load_robot(find(job.robot, beside=job_path))
    return make_plan(job, robot, kinematics_of(job, robot, job_path))


def _timed(
    job: JobFile,
    robot: RobotFile,
    limits: PathLimits,
    built: tuple[Lap, MappingFailed | None],
    repeat: int,
) -> TimedLap:
    lap, failed = built
    reach, margins = limits.check(lap, failed, repeat)
    schedule, led = _led_schedule(job, robot, lap, reach)
    if isinstance(schedule, CurveSchedule):
        limits.check_swing(*schedule.angle_range_rad())
    return TimedLap(lap, schedule, reach, margins, led)
