"""The wiring table: what the pins of a robot file are to be connected to on the 40-pin header.

`python -m deltactl.firmware_py.install.wiring config/zhao-2023.yaml` prints it as docs/wiring.md
has it. Source for the header: Raspberry Pi documentation, "GPIO and the 40-pin header" (and
`pinout` of gpiozero).
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from deltactl.firmware_py.robot_file import RobotFile, load_robot
from deltactl.models.robot import AXES

_PINS = "27 28 3 5 7 29 31 26 24 21 19 23 32 33 8 10 36 11 12 35 38 40 15 16 18 22 37 13"
PIN_OF_GPIO: Final = {gpio: int(pin) for gpio, pin in enumerate(_PINS.split())}
"""Header pin of each GPIO (BCM number)."""

POWER_3V3: Final = (1, 17)
GROUND: Final = (6, 9, 14, 20, 25, 30, 34, 39)

I2C_GPIO: Final[dict[int, tuple[int, int]]] = {0: (0, 1), 1: (2, 3)}
"""SDA and SCL of the buses that the header has without an overlay; others need an overlay."""

PULLED_UP_AT_BOOT: Final = range(9)
"""GPIO 0 to 8 are pulled up until a program claims them, the others down (BCM2835 ARM
Peripherals, table 6-31; the same on BCM2711 and RP1)."""


TITLES = ("GPIO", "Header pin", "Signal", "Connect to")


@dataclass(frozen=True, slots=True)
class Wire:
    """One connection of the header. `gpio` is None for supply and ground."""

    gpio: int | None
    pins: tuple[int, ...]
    signal: str
    to: str

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """As texts, in the order of TITLES."""
        gpio = "-" if self.gpio is None else str(self.gpio)
        *first, last = (str(pin) for pin in self.pins)
        pins = f"{', '.join(first)} or {last}" if first else last
        return gpio, pins, self.signal, self.to


def wiring(robot: RobotFile) -> tuple[Wire, ...]:
    """All connections of a robot, drives first."""
    return (*_drives(robot), *_inputs(robot), *_outputs(robot), *_sensors(robot))


def as_markdown(wires: tuple[Wire, ...]) -> str:
    """A table for a document."""
    rows = [TITLES, *(wire.cells for wire in wires)]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([lines[0], "|---|---|---|---|", *lines[1:]])


def as_text(wires: tuple[Wire, ...]) -> str:
    """A table for a terminal."""
    rows = [TITLES, *(wire.cells for wire in wires)]
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def _drives(robot: RobotFile) -> Iterator[Wire]:
    steps = robot.steps
    if robot.drive.kind == "servo":
        return  # servo drives hang on a fieldbus, not on pins
    for number, gpio in enumerate(steps.step_pins, 1):
        yield _wire(gpio, f"STEP {number}", f"PUL of drive {number}, through the 5 V buffer")
    for number, gpio in enumerate(steps.direction_pins, 1):
        yield _wire(gpio, f"DIR {number}", f"DIR of drive {number}, through the 5 V buffer")
    if steps.enable_pin is not None:
        level = _level(steps.enable_active_high)
        to = f"ENA of all drives, through the 5 V buffer; {level} energises them"
        yield _wire(steps.enable_pin, "ENA", to)
    for number, gpio in enumerate(steps.alarm_pins or (), 1):
        level = _level(steps.alarm_active_high)
        to = f"ALM+ of drive {number}, ALM- to ground; {level} is an alarm"
        yield _wire(gpio, f"ALM {number}", to)


def _inputs(robot: RobotFile) -> Iterator[Wire]:
    inputs, homing = robot.inputs, robot.homing
    if inputs.estop_pin is not None:
        contact = "normally closed" if inputs.estop_active_high else "normally open"
        to = f"e-stop button, {contact} contact to ground; {_level(inputs.estop_active_high)} stops"
        yield _wire(inputs.estop_pin, "E-STOP", to)
    for number, gpio in enumerate(homing.switch_pins or (), 1):
        level = _level(homing.switch_active_high)
        to = f"home switch of arm {number}, to ground; {level} is pressed"
        yield _wire(gpio, f"HOME {number}", to)
    for name, wired in inputs.named.items():
        to = f"{name}, to ground; {_level(wired.active_high)} is on"
        yield _wire(wired.pin, f"IN {name}", to)


def _outputs(robot: RobotFile) -> Iterator[Wire]:
    for name, output in robot.outputs.items():
        on, safe = _level(output.active_high), _level(output.level(output.safe))
        pull = "down" if safe == "low" else "up"
        to = f"{name}, through a driver; {on} is on, {safe} is safe (10 kOhm pull-{pull})"
        yield _wire(output.pin, f"OUT {name}", to)


def _sensors(robot: RobotFile) -> Iterator[Wire]:
    if robot.sensors is None:
        yield Wire(None, GROUND, "ground", "buffer, e-stop, ALM- of the drives")
        return
    ranging = robot.ranging
    for axis, gpio, address in zip(AXES, ranging.xshut_pins, ranging.addresses, strict=True):
        to = f"XSHUT of sensor {axis} (becomes I2C address 0x{address:02x})"
        yield _wire(gpio, f"XSHUT {axis}", to)
    names = ("SDA", "SCL")
    for name, gpio in zip(names, I2C_GPIO.get(ranging.bus, ()), strict=False):
        yield _wire(gpio, name, f"{name} of all three sensors (I2C bus {ranging.bus})")
    yield Wire(None, POWER_3V3, "3.3 V", "VIN of all three sensors")
    yield Wire(None, GROUND, "ground", "sensors, buffer, e-stop, ALM- of the drives")


def _wire(gpio: int, signal: str, to: str) -> Wire:
    return Wire(gpio, (PIN_OF_GPIO[gpio],), signal, to)


def _level(high: bool) -> str:
    return "high" if high else "low"


if __name__ == "__main__":
    print(as_markdown(wiring(load_robot(Path(sys.argv[1])))))
