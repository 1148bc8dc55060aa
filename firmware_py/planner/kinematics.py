"""The inverse kinematics a job chose."""

from __future__ import annotations

from pathlib import Path

from firmware_py.job_file import JobFile, NetworkIk
from firmware_py.robot_file import RobotFile, find
from models.inverse_kinematics import GeometricInverse, InverseKinematics


def kinematics_of(job: JobFile, robot: RobotFile, job_path: Path | None) -> InverseKinematics:
    """Geometry of the robot file, or the network named in the job (sought beside `job_path`).

    Raises MissingFile, or NetworkError (also for another robot's network).
    """
    chosen = job.inverse_kinematics
    if isinstance(chosen, NetworkIk):
        # Not at the top: the TFLite runtime takes a third of a second to load.
        from models.network import InverseNetwork

        return InverseNetwork.open(find(chosen.file, beside=job_path), robot)
    return GeometricInverse(robot.geometry)
