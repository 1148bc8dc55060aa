"""Pins read and written in this process through gpiozero: e-stop, alarms, switches, step lines.

Every input has the Pi's pull-up; switches, drives and buttons pull to ground. A line that
the pulse process watches (e-stop and alarms of its backend) cannot be claimed here as well.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from gpiozero import InputDevice, OutputDevice

from deltactl.drivers.settings import InputSettings, PinPerMotor, StepSettings
from deltactl.drivers.steps.lines import (
    ALARM_SHIFT,
    ENABLE_BIT,
    ESTOP_BIT,
    NO_SWITCHES,
    Switches,
)
from deltactl.foundation.errors import ConfigError, PulseFault


class InputLine:
    """One input. Raises ConfigError when the pin cannot be had."""

    def __init__(self, pin: int, active_high: bool, pin_factory: Any | None = None):
        try:
            self._device = InputDevice(pin, pull_up=True, pin_factory=pin_factory)
        except Exception as error:  # gpiozero's and lgpio's errors have no common root
            raise ConfigError(f"GPIO {pin} cannot be used as an input: {error}") from error
        self._active_high = active_high

    @property
    def level(self) -> bool:
        """What a meter would show."""
        return bool(self._device.pin.state)

    @property
    def active(self) -> bool:
        """Whether the line says what it is there to say."""
        return self.level == self._active_high

    def __call__(self) -> bool:
        """The same as `active`, to be handed on as a callable."""
        return self.active

    def close(self) -> None:
        """Give the pin back."""
        self._device.close()


def estop_input(settings: InputSettings, pin_factory: Any | None = None) -> InputLine | None:
    """The e-stop; active while pressed, or while its wire is open."""
    if settings.estop_pin is None:
        return None
    return InputLine(settings.estop_pin, settings.estop_active_high, pin_factory)


def alarm_inputs(settings: StepSettings, pin_factory: Any | None = None) -> tuple[InputLine, ...]:
    """ALM of each drive, in the order of the motors; empty when they are not wired."""
    return _lines(settings.alarm_pins or (), settings.alarm_active_high, pin_factory)


def home_switches(
    pins: PinPerMotor | None, active_high: bool, pin_factory: Any | None = None
) -> tuple[InputLine, ...]:
    """The home switch of each arm, active while pressed; empty when there are none."""
    return _lines(pins or (), active_high, pin_factory)


def named_inputs(settings: InputSettings, pin_factory: Any | None = None) -> dict[str, InputLine]:
    """What jobs wait for, by name; active while on."""
    found = settings.named.values()
    made: list[InputLine] = []
    try:
        for wired in found:
            made.append(InputLine(wired.pin, wired.active_high, pin_factory))  # noqa: PERF401
    except ConfigError:
        for line in made:
            line.close()
        raise
    return dict(zip(settings.named, made, strict=True))


def _lines(pins: Iterable[int], active_high: bool, pin_factory: Any) -> tuple[InputLine, ...]:
    made: list[InputLine] = []
    try:
        for pin in pins:
            made.append(InputLine(pin, active_high, pin_factory))  # noqa: PERF401 (closed if one fails)
    except ConfigError:
        for line in made:
            line.close()
        raise
    return tuple(made)


class GpiozeroLines:
    """A LineGroup of OutputDevices and InputDevices.

    STEP lines written together rise a few tens of microseconds apart. Closing turns the pins
    into inputs, as gpiozero does; a CL57T whose ENA is left open stays energised, and a switched
    output is then where its pull resistor puts it.
    """

    def __init__(
        self,
        settings: StepSettings,
        inputs: InputSettings,
        pin_factory: Any | None = None,
        switches: Switches = NO_SWITCHES,
    ):
        self._devices: dict[int, OutputDevice] = {}
        self._inputs: list[tuple[int, InputLine]] = []
        self._levels = 0
        try:
            self._claim(settings, inputs, switches, pin_factory)
        except ConfigError:
            self.close()
            raise
        except Exception as error:  # gpiozero's and lgpio's errors have no common root
            self.close()
            raise ConfigError(f"the step pins cannot be used: {error}") from error

    def write(self, levels: int, mask: int) -> None:
        """See LineGroup. Raises PulseFault."""
        changed = (self._levels ^ levels) & mask
        self._levels ^= changed
        try:
            while changed:
                bit = changed & -changed
                changed ^= bit
                device = self._devices.get(bit)
                if device is not None:
                    device.value = bool(levels & bit)
        except Exception as error:
            raise PulseFault(f"a step pin cannot be written: {error}") from error

    def read(self) -> int:
        """See LineGroup. Raises PulseFault."""
        levels = 0
        try:
            for bit, line in self._inputs:
                if line.level:
                    levels |= bit
        except Exception as error:
            raise PulseFault(f"an input pin cannot be read: {error}") from error
        return levels

    def close(self) -> None:
        for device in self._devices.values():
            device.close()
        for _, line in self._inputs:
            line.close()

    def _claim(
        self, settings: StepSettings, inputs: InputSettings, switches: Switches, factory: Any
    ) -> None:
        pins = [
            *(*settings.step_pins, *settings.direction_pins, settings.enable_pin),
            *switches.numbers,
        ]
        self._levels = ENABLE_BIT * (not settings.enable_active_high) | switches.safe_levels
        for position, pin in enumerate(pins):
            bit = 1 << position
            if pin is not None:
                self._devices[bit] = OutputDevice(
                    pin, initial_value=bool(self._levels & bit), pin_factory=factory
                )
        estop = estop_input(inputs, factory)
        if estop is not None:
            self._inputs.append((ESTOP_BIT, estop))
        for motor, line in enumerate(alarm_inputs(settings, factory)):
            self._inputs.append((1 << (ALARM_SHIFT + motor), line))
