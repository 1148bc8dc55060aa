"""The inverse kinematics a job chose."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.job_file import CalibratedIk, JobFile, NetworkIk
from deltactl.firmware_py.named_files import find
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import ConfigError
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.inverse_kinematics import GeometricInverse, InverseKinematics

if TYPE_CHECKING:
    from deltactl.models.network.file import NetworkFile


def network_file(
    chosen: NetworkIk, robot: RobotFile, job_path: Path | None, listing: bool = True
) -> Path:
    """The network a job means, or what the robot file says to take instead. Raises MissingFile."""
    return find(robot.networks.get(chosen.file, chosen.file), job_path, listing)


def read_network(path: Path, how: FileAccess) -> NetworkFile:
    """A network's file, read once. Raises MissingFile, NetworkError."""
    from deltactl.models.network.file import NetworkFile

    return how.once("network file", path, lambda: NetworkFile.load(path, how.follow))


def kinematics_of(
    job: JobFile, robot: RobotFile, job_path: Path | None, how: FileAccess | None = None
) -> InverseKinematics:
    """Geometry and known effects of the robot file, or the network named in the job.

    A network is sought beside `job_path`; how: with which access it is opened. Raises MissingFile,
    NetworkError (also for another robot's network), or ConfigError for a calibrated job of a
    robot file without effects.
    """
    chosen = job.inverse_kinematics
    if isinstance(chosen, NetworkIk):
        # Not at the top: the TFLite runtime takes a third of a second to load.
        from deltactl.models.network import InverseNetwork

        how = how or FileAccess()
        found = read_network(network_file(chosen, robot, job_path, how.follow), how)
        found.check(robot)
        return InverseNetwork(found)
    calibrated = CalibratedInverse(robot)
    if calibrated.effects:
        return calibrated
    if isinstance(chosen, CalibratedIk):
        raise ConfigError(
            f"inverse_kinematics: calibrated: robot '{robot.name}' has no effects in its file that "
            "could be corrected; name a calibrated robot file, or use kind: geometry"
        )
    return GeometricInverse(robot.geometry)
