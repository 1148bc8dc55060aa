"""A job that was read, checked and planned: here, or in a process of its own."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from firmware_py.planner.kinematics import kinematics_of
from firmware_py.planner.plan import Plan
from firmware_py.program.building import make_program
from firmware_py.program.includes import read_whole
from firmware_py.program.instructions import Program
from firmware_py.robot_file import RobotFile, find, load_robot
from foundation.errors import ConfigError, MissingFile
from foundation.strict_yaml import MAX_BYTES


@dataclass(frozen=True, slots=True)
class Prepared:
    """A program, and the text of the whole job it came from."""

    program: Program
    job_text: str

    @property
    def plan(self) -> Plan:
        """The plan of a job with one path."""
        plan = self.program.first
        assert plan is not None
        return plan


@dataclass(frozen=True, slots=True)
class InForce:
    """The robot that runs, and the file it was read from, as that was then."""

    robot: RobotFile
    path: Path
    text: str


Prepare = Callable[[Path, InForce], Prepared]


@dataclass(frozen=True, slots=True)
class Manners:
    """How a file is opened for somebody who may not be allowed to read it himself."""

    follow: bool = True
    """Whether links may lead to it."""
    quote: bool = True
    """Whether a refusal may say what stands in it."""
    most_bytes: int = MAX_BYTES


def prepare_here(job_file: Path, robot: InForce, manners: Manners | None = None) -> Prepared:
    """Read and check a job in this process; takes as long as mapping the whole path does.

    Raises ConfigError (also when the job is for another robot), NetworkError, MotionError.
    """
    how = manners or Manners()
    with discreet(job_file, how):
        whole = read_whole(job_file, how.follow, how.most_bytes)
        job = whole.job
    wanted = _wanted(job.robot, job_file, robot.path)
    same = wanted.resolve() == robot.path.resolve()
    if not same and not _is_machine(robot.robot, wanted, how):
        raise ConfigError(
            f"{job_file}: is for robot file {job.robot}, but this robot runs {robot.path.name};"
            " change 'robot' in the job, or start the daemon with the other file"
        )
    program = make_program(job, robot.robot, lambda one: kinematics_of(one, robot.robot, job_file))
    return Prepared(program, whole.text)


def _is_machine(robot: RobotFile, wanted: Path, how: Manners) -> bool:
    with discreet(wanted, how):
        return robot.is_machine_of(load_robot(wanted))


@contextmanager
def discreet(path: Path, how: Manners) -> Iterator[None]:
    """Where Manners forbid quoting, refuse a file without a word of what stands in it."""
    try:
        yield
    except MissingFile:
        raise
    except ConfigError as error:
        if how.quote:
            raise
        line = re.match(re.escape(str(path)) + r":\d+", str(error))
        raise ConfigError(
            f"{line.group() if line else path}: is not as such a file should be;"
            f" 'deltactl check {path}' says what is wrong, if you may read it"
        ) from None


def _wanted(name: str, job_file: Path, robot_file: Path) -> Path:
    """The robot file a job means: a plain name that nothing beside it has may be the one that runs.

    So a job that was sent as text can be for a robot file that is not in the project.
    """
    if name == robot_file.name and not (job_file.parent / name).is_file():
        return robot_file
    return find(name, beside=job_file)
