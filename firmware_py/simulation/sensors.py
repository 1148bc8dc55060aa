"""The distance sensors of a simulated robot, as its file describes them, with their own noise."""

from __future__ import annotations

from zlib import crc32

from deltactl.drivers.fakes.ranging_bench import RangingRig, build_rig
from deltactl.drivers.fakes.vl53l1x_scene import RangeNoise
from deltactl.drivers.ranging.contract import NoSensors, RangingSensors
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.simulation.world import SimulatedRobot
from deltactl.foundation.clock import Clock


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


def simulated_sensors(
    robot: RobotFile, clock: Clock, world: SimulatedRobot
) -> tuple[RangingSensors, RangingRig | None]:
    """The driver of the sensors that see `world`, and the fakes below it where there are any."""
    if robot.sensors is None:
        return NoSensors(), None
    rig = build_rig(robot.ranging, clock, world.distance_m, range_noise(robot))
    return rig.bank, rig
