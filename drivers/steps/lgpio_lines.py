"""The lines through lgpio: all outputs in one group, so three motors step in one ioctl.

Loaded by the pulse process only. lgpio writes a pipe `.lgd-nfy*` into the folder that LG_WD
names, and changes into it.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from types import ModuleType
from typing import Any, NamedTuple

from deltactl.drivers.pin_factory import NO_LGPIO, NoHeader, header_chip
from deltactl.drivers.steps.lines import SWITCH_SHIFT
from deltactl.foundation.errors import PulseFault


class LgpioPins(NamedTuple):
    """BCM numbers, as they travel to the pulse process."""

    chip: int | None
    """Number of the chip; None: it is found by its label."""
    outputs: list[int]
    """STEP 1 to 3, DIR 1 to 3 and, if there is one, ENA: in the order of the bits in lines.py."""
    output_levels: int
    """Levels to begin with."""
    estop: int | None
    alarms: list[int]
    switches: Sequence[int] = ()
    """Outputs that jobs switch."""
    switch_levels: int = 0
    """Their levels to begin with; the first in bit 0."""


class LgpioLines:
    """A LineGroup on a GPIO chip. Raises PulseFault when chip or lines cannot be had.

    Closing leaves the outputs at their last level (what the kernel does with a line that is
    given back): STEP low, ENA as it was.
    """

    def __init__(self, pins: LgpioPins, gpio: Any | None = None):
        if gpio is None:
            gpio = _library()
        self._gpio = gpio
        self._handle = self._open(pins.chip)
        self._outputs = pins.outputs[0]
        self._mask = (1 << len(pins.outputs)) - 1
        self._inputs, self._shift = self._input_group(pins)
        self._claim_outputs(pins.outputs, pins.output_levels)
        self._switches = pins.switches[0] if pins.switches else None
        if pins.switches:
            self._claim_outputs(list(pins.switches), pins.switch_levels)

    def write(self, levels: int, mask: int) -> None:
        try:
            if mask & self._mask:
                self._gpio.group_write(self._handle, self._outputs, levels, mask & self._mask)
            if mask >> SWITCH_SHIFT and self._switches is not None:
                shifted = levels >> SWITCH_SHIFT, mask >> SWITCH_SHIFT
                self._gpio.group_write(self._handle, self._switches, *shifted)
        except self._gpio.error as error:
            raise PulseFault(f"an output line cannot be written: {error}") from error

    def read(self) -> int:
        if self._inputs is None:
            return 0
        try:
            _, levels = self._gpio.group_read(self._handle, self._inputs)
        except self._gpio.error as error:
            raise PulseFault(f"an input line cannot be read: {error}") from error
        return int(levels) << self._shift

    def close(self) -> None:
        self._gpio.gpiochip_close(self._handle)

    def _open(self, chip: int | None) -> int:
        try:
            return header_chip(self._gpio, chip)[0]
        except NoHeader as error:
            raise PulseFault(str(error)) from error

    def _claim_outputs(self, pins: list[int], bits: int) -> None:
        levels = [bits >> bit & 1 for bit in range(len(pins))]
        try:
            self._gpio.group_claim_output(self._handle, pins, levels)
        except self._gpio.error as error:
            raise self._busy(pins, error) from error

    def _input_group(self, pins: LgpioPins) -> tuple[int | None, int]:
        """Claim the inputs. Returns their leader, and how far their bits must be shifted."""
        estop = [] if pins.estop is None else [pins.estop]
        group = [*estop, *pins.alarms]
        if not group:
            return None, 0
        try:
            self._gpio.group_claim_input(self._handle, group, self._gpio.SET_PULL_UP)
        except self._gpio.error as error:
            raise self._busy(group, error) from error
        return group[0], 0 if estop else 1

    def _busy(self, group: list[int], error: Exception) -> PulseFault:
        self._gpio.gpiochip_close(self._handle)
        names = ", ".join(str(pin) for pin in group)
        return PulseFault(f"GPIO {names} cannot be claimed ({error}); does another program run?")


def _library() -> ModuleType:
    try:
        return import_module("lgpio")
    except ImportError as error:
        raise PulseFault(NO_LGPIO) from error


def of_config(config: dict[str, Any]) -> LgpioLines:
    """The lines at the pins that the pulse process was told."""
    return LgpioLines(LgpioPins(*config["pins"]))
