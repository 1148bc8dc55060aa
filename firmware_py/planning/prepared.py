"""A job that was read, checked and planned: here, or in a process of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from firmware_py.job_file import JobFile
from firmware_py.planner.check import make_plan
from firmware_py.planner.kinematics import kinematics_of
from firmware_py.planner.plan import Plan
from firmware_py.robot_file import RobotFile, find, load_robot
from foundation.errors import ConfigError
from foundation.strict_yaml import Document


@dataclass(frozen=True, slots=True)
class Prepared:
    """A plan, and the text it came from."""

    plan: Plan
    job_text: str


@dataclass(frozen=True, slots=True)
class InForce:
    """The robot that runs, and the file it was read from, as that was then."""

    robot: RobotFile
    path: Path
    text: str


Prepare = Callable[[Path, InForce], Prepared]


def prepare_here(job_file: Path, robot: InForce) -> Prepared:
    """Read and check a job in this process; takes as long as mapping the whole path does.

    Raises ConfigError (also when the job is for another robot), NetworkError, MotionError.
    """
    document = Document.read(job_file)
    job = document.check(JobFile)
    wanted = _wanted(job.robot, job_file, robot.path)
    same = wanted.resolve() == robot.path.resolve()
    if not same and not robot.robot.is_machine_of(load_robot(wanted)):
        raise ConfigError(
            f"{job_file}: is for robot file {job.robot}, but this robot runs {robot.path.name};"
            " change 'robot' in the job, or start the daemon with the other file"
        )
    plan = make_plan(job, robot.robot, kinematics_of(job, robot.robot, job_file))
    return Prepared(plan, document.text)


def _wanted(name: str, job_file: Path, robot_file: Path) -> Path:
    """The robot file a job means: a plain name that nothing beside it has may be the one that runs.

    So a job that was sent as text can be for a robot file that is not in the project.
    """
    if name == robot_file.name and not (job_file.parent / name).is_file():
        return robot_file
    return find(name, beside=job_file)
