"""The robot file a data set belongs to."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.foundation.errors import ConfigError, MissingFile

if TYPE_CHECKING:
    from deltactl.models.training.dataset import DataSet


def robot_file_of(data: DataSet, named: str | None) -> Path:
    """The named robot file, or the one called like the data set's robot.

    Raises MissingFile, or ConfigError where nothing was named and no file is called so.
    """
    from deltactl.firmware_py.named_files import find

    if named is not None:
        return find(named)
    name = data.settings.robot
    try:
        return find(f"{name}.yaml")
    except MissingFile:
        raise ConfigError(
            f"{data.folder}: was taken with robot '{name}', and there is no {name}.yaml here or "
            "in config; name that robot's file with --robot"
        ) from None
