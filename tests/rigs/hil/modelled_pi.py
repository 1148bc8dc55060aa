"""A Raspberry Pi 4B with the robot wired up, below the system calls of a child process.

The child (the daemon, its pulse process) runs unmodified smbus2, gpiozero and lgpio against
/dev/i2c-N and /dev/gpiochipN; chips, drives, button, alarm wires and the simulated robot are
here. Does not model: what the parts say they do not, and the speed of a Pi: a call takes about
as long as on one, but the models share one interpreter and may hold a call up for milliseconds.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from deltactl.drivers.fakes.bench import FakeBench
from deltactl.drivers.fakes.gpio_chip import GpioChip
from deltactl.drivers.fakes.i2c_bus import FakeI2cBus, I2cAdapter
from deltactl.drivers.fakes.syscall_trap import SyscallTrap
from deltactl.drivers.fakes.vl53l1x_chip import DistanceOver, Vl53l1xChip
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.firmware_py.simulation.sensors import range_noise
from deltactl.firmware_py.simulation.world import SimulatedRobot
from deltactl.foundation.clock import RealClock
from deltactl.models.robot import AXES

TREE = Path("/proc/device-tree")
MODEL = b"Raspberry Pi 4 Model B Rev 1.1\0"
REVISION = (0xC03111).to_bytes(4, "big")
I2C_NODE = "/soc/i2c@7e804000"
GPIO_TYPE, I2C_TYPE = 0xB4, 0x07


class ModelledPi:
    """Start programs with `executable` instead of the Python interpreter.

    Raises what SyscallTrap raises; see `syscall_trap.available` for where it works.
    """

    def __init__(self, robot: RobotFile):
        clock = RealClock()
        self.robot = robot
        self.gpio = GpioChip()
        self.bench: FakeBench = FakeBench(robot.steps, robot.inputs, clock, pins=self.gpio)
        self.world = SimulatedRobot(robot, self.bench.counts_at, clock.now_ns)
        noise = range_noise(robot)
        self.chips = {
            axis: Vl53l1xChip(
                clock,
                self._distance(axis),
                replace(noise, seed=noise.seed + index),
            )
            for index, axis in enumerate(AXES)
        }
        self._solder_xshut()
        self.adapter = I2cAdapter(FakeI2cBus(clock, list(self.chips.values())))
        self._clock = clock
        self._trap = SyscallTrap(
            {
                f"/dev/gpiochip{robot.steps.chip or 0}": self.gpio,
                f"/dev/i2c-{robot.ranging.bus}": self.adapter,
            },
            (GPIO_TYPE, I2C_TYPE),
            _device_tree(robot.ranging.bus),
        )
        self.executable = self._trap.executable

    def put_to_stops(self) -> None:
        """The operator puts the arms against their stops; the drives must be released."""
        self.world.put_to_stops(self._clock.now_ns())

    def close(self) -> None:
        """Serve no further programs."""
        self._trap.close()
        self.bench.close()

    def _distance(self, axis: str) -> DistanceOver:
        return lambda start_ns, end_ns: self.world.distance_m(axis, start_ns, end_ns)

    def _solder_xshut(self) -> None:
        """Breakout boards pull XSHUT up."""
        for axis, pin in zip(AXES, self.robot.ranging.xshut_pins, strict=True):
            self.gpio.drive(pin, True)
            self.gpio.connect(pin, self.chips[axis].set_xshut)


def _device_tree(bus: int) -> dict[str, bytes]:
    """The files by which programs tell what machine this is."""
    return {
        str(TREE / "model"): MODEL,
        str(TREE / "system" / "linux,revision"): REVISION,
        str(TREE / "aliases" / f"i2c{bus}"): I2C_NODE.encode() + b"\0",
        f"{TREE}{I2C_NODE}/clock-frequency": (400_000).to_bytes(4, "big"),
    }
