"""Opens the sensors of a real robot: /dev/i2c-N and the XSHUT pins through gpiozero."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

from gpiozero import Device
from gpiozero.exc import GPIOZeroError

from deltactl.drivers.i2c import open_bus
from deltactl.drivers.ranging.bank import SensorBank
from deltactl.drivers.settings import RangingSettings
from deltactl.foundation.clock import Clock
from deltactl.foundation.errors import SensorFault


class OpenDrainLine:
    """A gpiozero pin that drives low or floats, as an XshutLine. Starts low.

    Breakout boards pull XSHUT up to their own supply, so the pin only ever drives low or lets
    go. Needs that pull-up; every VL53L1X breakout has one, the bare module has not.
    """

    def __init__(self, factory: Any, number: int):
        """`factory` is a gpiozero pin factory, `number` a BCM number."""
        self._factory = factory
        self._number = number
        factory.reserve_pins(self, number)
        self._pin = factory.pin(number)
        self.off()

    def __repr__(self) -> str:
        return f"OpenDrainLine(GPIO {self._number})"

    def _conflicts_with(self, other: object) -> bool:
        """Asked by gpiozero when something else wants the pin: never share it."""
        return True

    def off(self) -> None:
        """Drive low."""
        self._pin.output_with_state(0)

    def on(self) -> None:
        """Let go."""
        self._pin.input_with_pull("floating")

    def close(self) -> None:
        """Give the pin back, still low: the sensor stays in reset while the program lives."""
        self.off()
        self._factory.release_pins(self, self._number)


def open_robot_sensors(settings: RangingSettings, clock: Clock, factory: Any = None) -> SensorBank:
    """The three sensors of this machine, not yet started; `close` gives bus and pins back.

    `factory` is a gpiozero pin factory (default: gpiozero's own choice). Raises BusDead when the
    bus cannot be opened, SensorFault when an XSHUT pin cannot be had.
    """
    with ExitStack() as given_back:
        bus = open_bus(settings.bus)
        given_back.callback(bus.close)
        try:
            lines = _open_lines(settings, factory, given_back)
        except GPIOZeroError as error:
            pins = ", ".join(str(number) for number in settings.xshut_pins)
            raise SensorFault(
                f"the XSHUT pins (GPIO {pins}) cannot be had: {error}; is another program running?"
            ) from error
        return SensorBank(settings, bus, lines, clock, on_close=(given_back.pop_all().close,))


def _open_lines(
    settings: RangingSettings, factory: Any, given_back: ExitStack
) -> list[OpenDrainLine]:
    if factory is None:
        Device.ensure_pin_factory()
        factory = Device.pin_factory
    lines = []
    for number in settings.xshut_pins:
        line = OpenDrainLine(factory, number)
        given_back.callback(line.close)
        lines.append(line)
    return lines
