"""The network that belongs to a corrected robot file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from deltactl.firmware_py.named_files import TRAINED_FOLDER
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.errors import DeltactlError
from deltactl.models.network.file import NetworkFile

Progress = Callable[[str], None]


def trained(
    robot: RobotFile, out: Path, progress: Progress = lambda _: None
) -> tuple[str, Path, float] | None:
    """Train what knows the effects of a robot file: the network it stands for, its file, its error.

    The error is in degrees RMS, held out. None where no network of this robot is shipped. Raises
    NetworkError.
    """
    shipped = _shipped_network(robot)
    if shipped is None:
        return None
    from deltactl.models.training.corrected import train_corrected
    from deltactl.models.training.recipe import Task

    metadata = shipped.metadata
    task = Task(robot, metadata.domain, metadata.training.seed, metadata.angle_deg)

    def follow(done: int, total: int, text: str) -> None:
        progress(f"training the network: {100 * done // max(total, 1)} %, {text}")

    written = train_corrected(task, out, follow=follow)
    return shipped.path.name, out, written.file.metadata.validation.rmse_deg


def _shipped_network(robot: RobotFile) -> NetworkFile | None:
    """The network in models/trained that is of this robot."""
    for path in sorted(TRAINED_FOLDER.glob("*.tflite")):
        file = NetworkFile.load(path)
        try:
            file.check(robot)
        except DeltactlError:
            continue
        return file
    return None
