"""The noise of a simulated robot's range sensors: its own, and the same whenever it starts anew."""

from __future__ import annotations

from zlib import crc32

from deltactl.drivers.fakes.vl53l1x_optics import RangeNoise
from deltactl.firmware_py.robot_file import RobotFile


def range_noise(robot: RobotFile) -> RangeNoise:
    """Where the file gives no seed the name does: other robots scatter otherwise, runs repeat."""
    noise = robot.as_built.noise
    seed = crc32(robot.name.encode()) if noise.seed is None else noise.seed
    return RangeNoise(sigma_m=noise.sigma_m, correlation=noise.correlation, seed=seed)


def with_seed(robot: RobotFile, seed: int | None) -> RobotFile:
    """The robot with noise of this seed; None leaves it as it is."""
    if seed is None:
        return robot
    noise = robot.as_built.noise.model_copy(update={"seed": seed})
    as_built = robot.as_built.model_copy(update={"noise": noise})
    return robot.model_copy(update={"as_built": as_built})
