"""The lines as gpiozero devices: portable, in this process, one pin after the other."""

from __future__ import annotations

from typing import Any

from gpiozero import OutputDevice

from deltactl.drivers.inputs import InputLine, alarm_inputs, estop_input
from deltactl.drivers.settings import InputSettings, StepSettings
from deltactl.drivers.steps.lines import (
    ALARM_SHIFT,
    ENABLE_BIT,
    ESTOP_BIT,
)
from deltactl.drivers.steps.switches import NO_SWITCHES, Switches
from deltactl.foundation.errors import ConfigError, PulseFault


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
        """See LineGroup."""
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
