"""Pins through lgpio: the header's chip, gpiozero's pin factory on it, and the step lines.

Left to itself gpiozero tries one library after another and falls back in silence, to one
that may not see our other process's claims; and release 2.0.1 opens chip 4 on every Pi 5, which
kernels from 6.6.47 on call chip 0. So library and chip are named outright here. All outputs of the
step lines are in one group, so three motors step in one ioctl. lgpio writes a pipe `.lgd-nfy*` into
the folder that LG_WD names, and changes into it.
"""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from deltactl.drivers.steps.lines import SWITCH_SHIFT
from deltactl.foundation.errors import ConfigError, PulseFault

NO_LGPIO = (
    "the package lgpio is missing; type: sudo apt install python3-lgpio (a virtual environment sees"
    " it if made with --system-site-packages, as 'make run' makes it on a Raspberry Pi)"
)
"""PyPI has it up to Python 3.12 only; Raspberry Pi OS 13 has Python 3.13."""

HEADER_CHIPS = ("pinctrl-bcm2835", "pinctrl-bcm2711", "pinctrl-rp1")
"""Labels of the chips behind the 40-pin header: Pi 1 to 3, Pi 4, Pi 5."""
CHIPS = range(10)
"""Numbers that a header's chip may have."""


def header_chip(gpio: Any, number: int | None) -> tuple[int, int]:
    """Open the chip behind the header: lgpio's handle, and the number of its device.

    number: of the chip, where the robot file names one; None finds it by its label. gpio: lgpio
    or a substitute. Raises PulseFault, with the device, when no chip can be used as the header.
    """
    refused = []
    for candidate in CHIPS if number is None else [number]:
        try:
            handle = int(gpio.gpiochip_open(candidate))
        except gpio.error as error:
            refused.append((candidate, error))
            continue
        label = str(gpio.gpio_get_chip_info(handle)[3])
        if label.startswith(HEADER_CHIPS):
            return handle, candidate
        gpio.gpiochip_close(handle)
        refused.append((candidate, label))
    raise PulseFault(_why_none(refused, number))


def _why_none(refused: list[tuple[int, Any]], number: int | None) -> str:
    """refused: chips, each with the label that it has or the error with which it does not open."""
    others = [f"{device(chip)} is '{why}'" for chip, why in refused if isinstance(why, str)]
    shut = [
        f"{device(chip)} cannot be opened ({why})"
        for chip, why in refused
        if not isinstance(why, str) and Path(device(chip)).exists()
    ]
    if not others and not shut:
        if number is None:
            return f"{device(0)} does not exist, nor do 1 to {CHIPS[-1]}: no GPIO header here"
        return f"{device(number)} does not exist: no GPIO header here, or steps.chip is wrong"
    wrong = [f"{', '.join(others)}, not the 40-pin header"] if others else []
    if shut:
        return f"{', '.join(wrong + shut)}; the user must be in the group gpio"
    if number is None:
        return f"{wrong[0]}, and no other chip is here"
    return f"{wrong[0]}; leave steps.chip out, and the header's is found by its label"


def device(number: int) -> str:
    """The device of a chip."""
    return f"/dev/gpiochip{number}"


def lgpio_pin_factory(chip: int | None = None) -> Any:
    """A gpiozero LGPIOFactory on the header; `chip` as in `header_chip`.

    Raises ConfigError when this machine has no usable GPIO.
    """
    here = Path.cwd()
    os.environ.setdefault("LG_WD", os.environ.get("RUNTIME_DIRECTORY") or _private_folder())
    try:
        return _factory(chip)
    except ImportError as error:
        raise ConfigError(NO_LGPIO) from error
    except Exception as error:  # lgpio.error, PinUnknownPi and OSError have no common root
        raise ConfigError(f"the GPIO pins of this machine cannot be used: {error}") from error
    finally:
        os.chdir(here)  # importing lgpio changes into LG_WD


def _factory(chip: int | None) -> Any:
    import lgpio
    from gpiozero.pins.lgpio import LGPIOFactory, LGPIOPin
    from gpiozero.pins.local import LocalPiFactory

    class HeaderFactory(LGPIOFactory):  # type: ignore[misc]  # gpiozero has no types
        """LGPIOFactory whose `chip` is heard."""

        def __init__(self) -> None:
            LocalPiFactory.__init__(self)
            self._handle, self._chip = header_chip(lgpio, chip)
            self.pin_class = LGPIOPin

    return HeaderFactory()


def _private_folder() -> str:
    """Where lgpio may leave its notification pipe while this process lives."""
    folder = tempfile.mkdtemp(prefix="deltactl-lgpio-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


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
        self._handle, _ = header_chip(gpio, pins.chip)
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
    """The lines at the configured pins of the pulse process."""
    return LgpioLines(LgpioPins(*config["pins"]))
