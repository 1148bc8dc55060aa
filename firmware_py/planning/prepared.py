"""A job that was read, checked and planned: here, or in a process of its own."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from deltactl.firmware_py.file_access import FileAccess, Stamp, stamp_of, without_quoting
from deltactl.firmware_py.job_file import JobFile, NetworkIk
from deltactl.firmware_py.job_targets import kinematics_of, network_file
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.planner.plan import Plan
from deltactl.firmware_py.program.building import make_program, told_with
from deltactl.firmware_py.program.includes import read_whole
from deltactl.firmware_py.program.instructions import Program
from deltactl.firmware_py.robot_file import RobotFile, robot_in
from deltactl.foundation.errors import ConfigError, ServiceError
from deltactl.foundation.strict_yaml import Document
from deltactl.models.inverse_kinematics import InverseKinematics


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
    started: Path | None = None
    """The file that the daemon was started with, where another is in force by now: jobs may name
    it all the same, as it is of the same machine."""

    @property
    def paths(self) -> tuple[Path, ...]:
        """By which a job may mean this robot."""
        return (self.path,) if self.started is None else (self.path, self.started)


class CalledOff(Protocol):
    """Says when a job that is being prepared is not wanted any more."""

    def when_called_off(self, callback: Callable[[], None]) -> None:
        """Call it then, from any thread."""


class Prepare(Protocol):
    """Reads, checks and plans a job."""

    def __call__(self, job_file: Path, robot: InForce, asked: CalledOff, /) -> Prepared:
        """Raises what is wrong with the job, and anything at all once it is called off."""


def prepare_for(job_file: Path, robot: InForce, asked: CalledOff) -> Prepared:
    """In this process, to the end: a job that was called off meanwhile is not run."""
    return prepare_here(job_file, robot)


def prepare_with(how: FileAccess, job_file: Path, robot: InForce, asked: CalledOff) -> Prepared:
    """As `prepare_for`, with what was read before."""
    return prepare_here(job_file, robot, how)


def prepare_here(job_file: Path, robot: InForce, access: FileAccess | None = None) -> Prepared:
    """Read and check a job in this process; takes as long as mapping the whole path does.

    Raises ConfigError (also when the job is for another robot), NetworkError, MotionError.
    """
    how = access or FileAccess()
    whole = read_whole(job_file, how)
    job = whole.job
    wanted = _wanted(job.robot, job_file, robot, how)
    same = wanted.resolve() in {path.resolve() for path in robot.paths}
    if not same and not _is_machine(robot.robot, wanted, how.named):
        raise ConfigError(
            f"{job_file}: is for robot file {job.robot}, but this robot runs {robot.path.name};"
            " change 'robot' in the job, leave --robot out, or start the daemon with the other file"
        )
    with told_with(job_file.name):
        program = make_program(
            job, robot.robot, lambda one: kinematics_for(one, robot.robot, job_file, how)
        )
    return Prepared(program, whole.text)


def kinematics_for(
    job: JobFile, robot: RobotFile, job_file: Path, how: FileAccess
) -> InverseKinematics:
    """As `kinematics_of`; its network is opened with this access, once."""
    chosen = job.inverse_kinematics
    if not isinstance(chosen, NetworkIk):
        return kinematics_of(job, robot, job_file)
    file = network_file(chosen, robot, job_file, how.follow)
    with without_quoting(file, how.named):
        return how.once("network", file, lambda: kinematics_of(job, robot, job_file, how))


def _is_machine(robot: RobotFile, wanted: Path, how: FileAccess) -> bool:
    with without_quoting(wanted, how):
        return robot.is_machine_of(how.robot(wanted))


def _wanted(name: str, job_file: Path, robot: InForce, how: FileAccess) -> Path:
    """The robot file a job means: a plain name that nothing beside it has may be the one that runs.

    So a job that was sent as text can be for a robot file that is not in the project.
    """
    if not (job_file.parent / name).is_file():
        for path in robot.paths:
            if name == path.name:
                return path
    return find(name, job_file, listing=how.follow)


@dataclass(frozen=True, slots=True)
class RobotRead:
    """A robot, and the text that says it."""

    robot: RobotFile
    text: str
    stamp: Stamp
    """Stamp of the file before it was read."""

    def message(self) -> dict[str, Any]:
        """As plain values; keys that the file leaves out stay left out."""
        robot = self.robot.model_dump(mode="json", exclude_unset=True)
        return {"robot": robot, "text": self.text, "stamp": self.stamp}

    @classmethod
    def of(cls, message: dict[str, Any]) -> RobotRead:
        """The same again. Raises ServiceError when that is none."""
        try:
            robot = RobotFile.model_validate_json(json.dumps(message["robot"]))
            changed, size, inode = map(int, message["stamp"])
            return cls(robot, str(message["text"]), (changed, size, inode))
        except (KeyError, TypeError, ValueError) as error:
            raise ServiceError(f"the reader's answer cannot be read ({error})") from error


ReadRobot = Callable[[Path, FileAccess], RobotRead]


def read_robot_here(path: Path, access: FileAccess) -> RobotRead:
    """Read and check a robot file in this process. Raises MissingFile, ConfigError."""
    stamp = stamp_of(path)
    with without_quoting(path, access):
        document = Document.read(path, access.follow, access.most_bytes)
        return RobotRead(robot_in(document), document.text, stamp)


def read_robot_once(path: Path, access: FileAccess) -> RobotRead:
    """As `read_robot_here`, or what this access has read before."""
    return RobotRead(access.robot(path), access.document(path).text, access.stamp(path))


@dataclass(frozen=True, slots=True)
class Readers:
    """Who reads and plans jobs, and who reads robot files once the controller runs.

    before: what was read already, for one job: its robot file, the job and its network are not read
    again.
    """

    prepare: Prepare = prepare_for
    read: ReadRobot = read_robot_here
    before: FileAccess | None = None

    def begin(self, robot_file: Path) -> tuple[RobotRead, Prepare]:
        """The robot file to begin with, and who prepares jobs. Raises MissingFile, ConfigError."""
        if self.before is None:
            return read_robot_here(robot_file, FileAccess()), self.prepare
        return read_robot_once(robot_file, self.before), partial(prepare_with, self.before)


HERE = Readers()
"""In this process."""
