"""From a job with one path to a plan that may run, also for a robot that remembers."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.compensation.remembering import Course, Remembering
from deltactl.firmware_py.job_file import JobFile, load_job, way_in_mps
from deltactl.firmware_py.kinematics_of_job import kinematics_of
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.path_of_job import path_of
from deltactl.firmware_py.paths.path import Space
from deltactl.firmware_py.planner.limits import PathLimits
from deltactl.firmware_py.planner.plan import Plan, TimedLap, schedule_of
from deltactl.firmware_py.planner.targets import Lap, LapBuilder, MappingFailed
from deltactl.firmware_py.planner.timing_accelerated import CurveSchedule
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.clock import NS_PER_S
from deltactl.foundation.errors import ConfigError
from deltactl.models.inverse_kinematics import InverseKinematics
from deltactl.models.linkage import Linkage
from deltactl.models.robot import FloatArray

USUAL_START_S = 3.0
"""From switching the drives on to the start of a path, for what changes as the arms warm up."""


class LapMemory:
    """Commands the first and every later lap of one plan."""

    def __init__(self, robot: RobotFile, remembering: Remembering):
        self._remembering = remembering
        self._step_rad = robot.drive.rad_per_step
        self._first_rad: FloatArray | None = None
        """Mapped angles of the first lap."""
        self._again_rad: FloatArray | None = None

    def first(self, timed: TimedLap) -> Lap:
        """The first lap; the way to it takes play up in the direction it will set out in."""
        if self._first_rad is None:
            self._first_rad = timed.lap.angles_rad
        mapped = Course(_times_s(timed), self._first_rad)
        before = self._remembering.before(mapped)
        return self._commanded(timed.lap, self._remembering.angles_rad(mapped, before))

    def again(self, timed: TimedLap, first: TimedLap) -> Lap:
        """Every later lap: it begins where the one before ended, and ends there too.

        Growth is followed up to the second lap; what little is left of it later is not.
        """
        if self._again_rad is None:
            self._again_rad = timed.lap.angles_rad
        earlier = Course(_times_s(first), first.lap.angles_rad)
        begins_s = float(earlier.t_s[-1]) + float(first.lap.dwell_s[-1])
        mapped = Course(begins_s + _times_s(timed) - USUAL_START_S, self._again_rad)
        commanded = self._remembering.angles_rad(mapped, earlier)
        commanded[0] = commanded[-1] = first.lap.angles_rad[-1]
        return self._commanded(timed.lap, commanded)

    def preload_rad(self) -> FloatArray | None:
        """How far before the start of the path the way to it begins, (3,) [rad].

        As the arms are meant to set out, which is what the first lap was worked out for: where an
        arm turns round within a step of the start, what is commanded may set out the other way.
        """
        if self._first_rad is None:
            return None
        preload = self._remembering.preload_rad(self._first_rad)
        return preload if preload.any() else None

    def _commanded(self, lap: Lap, angles_rad: FloatArray) -> Lap:
        counts = np.rint(angles_rad / self._step_rad).astype(np.int64)
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
    return Plan(
        job, robot, kinematics, first, again, float(path.dwell_s[0]), way_in_mps=way_in_mps(job)
    )


def _with_memory(
    job: JobFile, robot: RobotFile, kinematics: InverseKinematics, remembering: Remembering
) -> Plan:
    """The same where arms have play or grow: laps are planned, then commanded otherwise."""
    limits, path = PathLimits(job, robot), path_of(job, robot)
    builder = LapBuilder(kinematics, Linkage.of(robot.geometry), robot.drive.rad_per_step)
    memory = LapMemory(robot, remembering)
    first = _timed(job, robot, limits, builder.first(path), 1)
    for _ in range(TIMED_AGAIN):
        first = _timed(job, robot, limits, (memory.first(first), None), 1)
    again = None
    if job.repeats > 1:
        built = builder.first(path) if path.is_closed else builder.again(path)
        again = _timed(job, robot, limits, built, 2)
        for _ in range(TIMED_AGAIN):
            again = _timed(job, robot, limits, (memory.again(again, first), None), 2)
    return Plan(
        job, robot, kinematics, first, again, float(path.dwell_s[0]), memory.preload_rad(),
        way_in_mps(job),
    )  # fmt: skip


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
    schedule = schedule_of(job, robot, lap, reach)
    if isinstance(schedule, CurveSchedule):
        limits.check_swing(*schedule.angle_range_rad())
    return TimedLap(lap, schedule, reach, margins)
