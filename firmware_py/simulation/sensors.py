"""The ranging sensors of a simulated robot: those that its file describes, and no others."""

from __future__ import annotations

from deltactl.drivers.fakes.ranging_bench import RangingRig, build_rig
from deltactl.drivers.ranging.contract import NoSensors, RangingSensors
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.simulation.noise import range_noise
from deltactl.firmware_py.simulation.world import SimulatedRobot
from deltactl.foundation.clock import Clock


def simulated_sensors(
    robot: RobotFile, clock: Clock, world: SimulatedRobot
) -> tuple[RangingSensors, RangingRig | None]:
    """The driver of the sensors that see `world`, and the fakes below it where there are any."""
    if robot.sensors is None:
        return NoSensors(), None
    rig = build_rig(robot.ranging, clock, world.distance_m, range_noise(robot))
    return rig.bank, rig
