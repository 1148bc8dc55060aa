"""Jobs waiting to run: checked, planned, and with a place for their recording."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from firmware_py.controller.file_in_force import FileInForce
from firmware_py.job_file import JobFile
from firmware_py.planner.check import make_plan
from firmware_py.planner.kinematics import kinematics_of
from firmware_py.planner.plan import Plan
from firmware_py.robot_file import RobotFile, find, load_robot
from foundation.errors import ConfigError, RecordingError
from foundation.strict_yaml import Document
from recording.names import confined, fresh_path


@dataclass(frozen=True, slots=True)
class QueuedJob:
    """A job that passed its check."""

    number: int
    name: str
    job_file: Path
    plan: Plan
    recording: Path
    robot_text: str
    job_text: str
    """What the recording carries with it."""


def prepare(
    number: int,
    job_file: Path,
    record: Path | None,
    robot: RobotFile,
    in_force: FileInForce,
    recordings: Path,
) -> QueuedJob:
    """Read and check a job for `robot`, which was loaded from the file in force.

    Raises ConfigError (also when the job is for another robot), NetworkError, MotionError,
    RecordingError. Takes as long as mapping the whole path does.
    """
    document = Document.read(job_file)
    job = document.check(JobFile)
    wanted = _wanted(job.robot, job_file, in_force.path)
    same = wanted.resolve() == in_force.path.resolve()
    if not same and not robot.is_machine_of(load_robot(wanted)):
        raise ConfigError(
            f"{job_file}: is for robot file {job.robot}, but this robot runs {in_force.path.name};"
            " change 'robot' in the job, or start the daemon with the other file"
        )
    plan = make_plan(job, robot, kinematics_of(job, robot, job_file))
    # Not beside the working directory: a service has none worth the name.
    chosen = record or (confined(recordings, job.record) if job.record else None)
    return QueuedJob(
        number,
        job.name,
        job_file,
        plan,
        _place(job.name, chosen, recordings),
        in_force.text,
        document.text,
    )


def _place(name: str, chosen: Path | None, recordings: Path) -> Path:
    """Where the recording goes; an existing file is never written over. Raises RecordingError."""
    if chosen is not None:
        path = chosen if chosen.suffix == ".mcap" else chosen.with_suffix(".mcap")
        if path.exists():
            raise RecordingError(f"{path}: exists already; choose another name or move it away")
        return path
    return fresh_path(recordings, name)


def _wanted(name: str, job_file: Path, robot_file: Path) -> Path:
    """The robot file a job means: a plain name that nothing beside it has may be the one that runs.

    So a job that was sent as text can be for a robot file that is not in the project.
    """
    if name == robot_file.name and not (job_file.parent / name).is_file():
        return robot_file
    return find(name, beside=job_file)
