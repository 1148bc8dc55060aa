"""What a training can learn from: a data set somebody collected, or the robot file's geometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.foundation.errors import ConfigError
from deltactl.models.linkage import Linkage
from deltactl.models.network.metadata import Box, Cylinder
from deltactl.models.robot import DeltaRobot, FloatArray
from deltactl.models.training.dataset import FEWEST, DataSet
from deltactl.models.training.samples import random_poses

ANGLE_DEG = (-20.0, 110.0)
"""Zhao 2023, section 3: the angles that are drawn."""


@dataclass(frozen=True, eq=False)
class Source:
    """Positions [m] and commanded arm angles [rad], both (n, 3), and where they come from."""

    robot: DeltaRobot
    position_m: FloatArray
    angles_rad: FloatArray
    domain: Cylinder | Box
    """Where a network of these samples may be asked."""
    angle_deg: tuple[float, float]
    words: str
    digest: str = ""
    machine: str = ""
    """The machine that was measured, if one was."""

    def __len__(self) -> int:
        return len(self.position_m)


def of_dataset(data: DataSet, robot: DeltaRobot, first: int | None = None) -> Source:
    """A data set's samples, all or the first so many.

    The domain is the box that holds them. Raises RecordingError for a data set of another robot,
    too few samples, NaN or a constant column.
    """
    used = data if first is None else data.first(first)
    used.check(robot, FEWEST)
    low_m, high_m = used.position_m.min(axis=0), used.position_m.max(axis=0)
    x, y, z = ((float(low), float(high)) for low, high in zip(low_m, high_m, strict=True))
    return Source(
        robot=robot,
        position_m=used.position_m,
        angles_rad=used.angles_rad,
        domain=Box(x_m=x, y_m=y, z_m=z),
        angle_deg=_outward(used.angles_rad),
        words=f"data set {used.folder.name}: {used.settings.machine} {used.settings.source}",
        digest=used.digest,
        machine=used.settings.machine_words,
    )


def of_geometry(robot: DeltaRobot, count: int, seed: int) -> Source:
    """Exact samples of the robot file's geometry: of random angles.

    Raises NetworkError where the geometry cannot be assembled, ConfigError for too few samples.
    """
    if count < FEWEST:
        raise ConfigError(f"{count} samples are too few to learn from; take at least {FEWEST}")
    linkage = Linkage.of(robot.geometry)
    position_m, angles_rad = random_poses(linkage, count, ANGLE_DEG, seed)
    low_m, high_m = position_m.min(axis=0), position_m.max(axis=0)
    x, y, z = ((float(low), float(high)) for low, high in zip(low_m, high_m, strict=True))
    box = Box(x_m=x, y_m=y, z_m=z)
    return Source(robot, position_m, angles_rad, box, ANGLE_DEG, "geometry, random angles")


def _outward(angles_rad: FloatArray) -> tuple[float, float]:
    """Lowest and highest angle [deg], to a whole degree outward."""
    low_deg, high_deg = np.rad2deg((angles_rad.min(), angles_rad.max()))
    return float(np.floor(low_deg)), float(np.ceil(high_deg))
