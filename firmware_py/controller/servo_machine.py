"""The simulated machine of a robot with servo drives."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from deltactl.drivers.current_drives import JOINTS, Plant
from deltactl.drivers.fakes.bench import FakeBench
from deltactl.drivers.fakes.current_drives import FakeCurrentDrives
from deltactl.drivers.fakes.mock_pins import FakeHomeSwitch
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.servo.as_built import AsBuiltServo
from deltactl.firmware_py.servo.output import ServoOutput
from deltactl.firmware_py.simulation.sensors import simulated_sensors
from deltactl.firmware_py.simulation.servo_world import ServoWorld, plant_of
from deltactl.foundation.clock import Clock, ns
from deltactl.foundation.errors import ConfigError
from deltactl.models.robot import Masses
from deltactl.models.servo_drive import ServoDrive

PlantMaker = Callable[[RobotFile, ServoDrive, Masses], Plant]


def servo_machine(robot: RobotFile, clock: Clock, make_plant: PlantMaker = plant_of) -> Machine:
    """Fake drives and sensors around a plant; another than `models.dynamics` may be given."""
    drive, masses = robot.drive, robot.masses
    if not isinstance(drive, ServoDrive) or masses is None:
        raise ConfigError(f"robot '{robot.name}' has no drive of kind servo with masses")
    plant = make_plant(robot, drive, masses)
    built = robot.as_built.servo or AsBuiltServo()
    drives = FakeCurrentDrives(
        plant,
        period_s=drive.period_s,
        rad_per_count=drive.rad_per_count,
        current_limit_a=drive.current_limit_a,
        brakes=drive.brake == "holding",
        faults=tuple(fault.planned() for fault in built.faults),
    )
    bench = FakeBench(robot.steps, robot.inputs, clock, shared=False)
    world = ServoWorld(robot, drives, clock.now_ns)
    output = ServoOutput(
        drive,
        drives,
        clock,
        ns(robot.steps.heartbeat_s),
        estop_pressed=lambda: bench.memory.estop_pressed,
        on_block=world.passed,
    )
    sensors, rig = simulated_sensors(robot, clock, world)
    return Machine(
        clock=clock,
        output=output,
        sensors=sensors,
        world=world,
        bench=bench,
        rig=rig,
        servo=output,
        drives=drives,
        inputs=bench.wired_inputs(robot.as_built.inputs),
        home_switches=tuple(
            FakeHomeSwitch(partial(world.above_home_rad, motor)) for motor in range(JOINTS)
        ),
        closers=(bench.close,),
    )
