"""What a job file would do, without doing it."""

from __future__ import annotations

from pathlib import Path

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.kinematics_of_job import kinematics_of
from deltactl.firmware_py.named_files import ROBOT_KEY, find
from deltactl.firmware_py.planner.plan import home_counts
from deltactl.firmware_py.planner.summary import CheckSummary
from deltactl.firmware_py.program.building import make_program
from deltactl.firmware_py.program.includes import read_whole
from deltactl.firmware_py.program.instructions import Program
from deltactl.firmware_py.program.naming import told_with
from deltactl.firmware_py.program.totals import summarise_program
from deltactl.firmware_py.robot_file import RobotFile, load_robot


def check_job(
    job_path: Path, from_counts: Counts | None = None, robot_file: Path | None = None
) -> CheckSummary:
    """Dry run of a job file from home (or other counts): what it would do.

    `robot_file`: instead of the one the job names. Raises MissingFile, ConfigError,
    NetworkError, UnreachablePoint or LimitExceeded.
    """
    robot = None if robot_file is None else load_robot(robot_file)
    program = program_of(job_path, robot, from_counts)
    return summarise_program(program, from_counts or home_counts(program.robot))


def program_of(
    job_path: Path, robot: RobotFile | None = None, from_counts: Counts | None = None
) -> Program:
    """The program of a job file, for the robot it names or for one that is there already."""
    job = read_whole(job_path, robot=robot).job
    if robot is None:
        robot = load_robot(find(job.robot, beside=job_path, key=ROBOT_KEY))
    known = robot
    with told_with(job_path):
        return make_program(
            job, known, lambda one: kinematics_of(one, known, job_path), from_counts
        )
