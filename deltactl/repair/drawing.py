"""The job that is drawn before and after: one of the machine that is healed."""

from __future__ import annotations

from pathlib import Path

import yaml

from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.named_files import CONFIG_FOLDER, find
from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.foundation.errors import ConfigError
from deltactl.foundation.plain_file import said_of_output, write_whole

HEART = CONFIG_FOLDER / "demo-heart.yaml"


def heart_for(robot_file: Path, folder: Path) -> Path:
    """The heart as a job for this robot file, whatever machine that describes."""
    job = yaml.safe_load(HEART.read_text(encoding="utf-8")) | {"robot": str(robot_file.resolve())}
    path = folder / HEART.name
    folder.mkdir(parents=True, exist_ok=True)
    with said_of_output(path):
        write_whole(path, yaml.safe_dump(job, sort_keys=False))
    return path


def refuse_other_machine(job: Path, robot: RobotFile) -> None:
    """Raises ConfigError for a job whose robot file describes another machine."""
    named = load_job(job).robot
    if not robot.is_machine_of(load_robot(find(named, beside=job))):
        raise ConfigError(
            f"{job.name}: is for robot file {named}, which describes another machine than the one"
            f" that is healed ('{robot.name}'); change 'robot' in the job, or name another --job"
        )
