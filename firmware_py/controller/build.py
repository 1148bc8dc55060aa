"""Builds the machine and its controller: on the hardware, or on the simulated robot."""

from __future__ import annotations

import gc
from functools import partial
from pathlib import Path

from deltactl.drivers.fakes.bench import simulated_step_output
from deltactl.drivers.fakes.mock_pins import FakeHomeSwitch
from deltactl.drivers.ranging.contract import NoSensors, RangingSensors
from deltactl.drivers.steps.build import build_step_output, release_drives
from deltactl.drivers.steps.contract import MOTORS
from deltactl.drivers.steps.gpiozero_pins import home_switches, named_inputs
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.file_in_force import keep_text
from deltactl.firmware_py.controller.servo_machine import servo_machine
from deltactl.firmware_py.machine import Machine
from deltactl.firmware_py.planning.prepared import HERE, Readers
from deltactl.firmware_py.robot_file import RobotFile, check_said
from deltactl.firmware_py.simulation.sensors import simulated_sensors, with_seed
from deltactl.firmware_py.simulation.world import HiddenEffects, SimulatedRobot, nothing_apart
from deltactl.foundation.clock import Clock, RealClock, VirtualClock
from deltactl.foundation.errors import ConfigError


def build_controller(
    robot_file: Path,
    *,
    simulated: bool,
    realtime: bool,
    recordings: Path,
    readers: Readers = HERE,
    seed: int | None = None,
    as_built: Path | None = None,
) -> Controller:
    """A controller, switched off. `realtime` and `seed` (of the noise) matter in simulation only.

    as_built: a separate file that describes the simulated robot (`HiddenEffects`).

    Raises ConfigError, or HardwareError when pins, bus or pulse process cannot be had.
    """
    found, prepare = readers.begin(robot_file)
    robot = found.robot
    if realtime or not simulated:
        keep_text(found.text)  # before its lines are claimed
        _load_ahead()
    if simulated:
        machine = simulated_machine(with_seed(robot, seed), realtime, as_built)
    else:
        machine = real_machine(robot)
    return Controller(robot, robot_file, machine, recordings, prepare, readers.read, found)


def _load_ahead() -> None:
    """Load now what would hold up a running motion for longer than its heartbeat allows.

    The TFLite runtime takes a third of a second to import, and the collector as long to look
    through everything that is imported.
    """
    from deltactl.models.network import InverseNetwork
    from deltactl.models.network.inverse import load_runtime

    del InverseNetwork
    load_runtime()
    gc.collect()
    gc.freeze()


def simulated_machine(robot: RobotFile, realtime: bool, as_built: Path | None = None) -> Machine:
    """The fakes with the simulated robot behind them. Raises ConfigError."""
    clock: Clock = RealClock() if realtime else VirtualClock()
    apart = nothing_apart if as_built is None else HiddenEffects(as_built).effects
    if robot.drive.kind == "servo":
        if as_built is not None:
            raise ConfigError(f"{as_built}: only for steppers; a servo robot has as_built.servo")
        return servo_machine(robot, clock)
    steps = simulated_step_output(
        robot.steps, robot.inputs, clock, realtime=realtime, switches=robot.switches
    )
    world = SimulatedRobot(robot, steps.bench.counts_at, clock.now_ns, apart)
    sensors, rig = simulated_sensors(robot, clock, world)
    return Machine(
        clock=clock,
        output=steps.output,
        sensors=sensors,
        world=world,
        bench=steps.bench,
        rig=rig,
        switches=robot.switches,
        inputs=steps.bench.wired_inputs(robot.as_built.inputs),
        home_switches=tuple(
            FakeHomeSwitch(partial(world.above_home_rad, motor)) for motor in range(MOTORS)
        ),
        release=steps.bench.release_drives,
        closers=(steps.bench.close,),
    )


def real_machine(robot: RobotFile) -> Machine:
    """The Pi's pins and bus. Raises HardwareError naming what is not there, ConfigError."""
    from deltactl.drivers.ranging.robot_sensors import open_robot_sensors
    from deltactl.drivers.steps.lgpio_pins import lgpio_pin_factory

    if robot.drive.kind == "servo":
        raise ConfigError(
            f"robot '{robot.name}': there is no driver for real servo drives (drive.kind servo);"
            " run it simulated"
        )
    check_said(robot)
    clock, homing = RealClock(), robot.homing
    pins = lgpio_pin_factory(robot.steps.chip)
    sensors: RangingSensors = NoSensors()
    if robot.sensors is not None:
        sensors = open_robot_sensors(robot.ranging, clock, pins)
    output = build_step_output(
        robot.steps, robot.inputs, clock, pin_factory=pins, switches=robot.switches
    )
    switches = home_switches(homing.switch_pins, homing.switch_active_high, pins)
    inputs = named_inputs(robot.inputs, pins)
    return Machine(
        clock=clock,
        output=output,
        sensors=sensors,
        switches=robot.switches,
        inputs=inputs,
        home_switches=switches,
        release=partial(release_drives, robot.steps, robot.inputs, robot.switches),
        closers=tuple(line.close for line in (*switches, *inputs.values())),
    )
