"""The chip behind the 40-pin header, and gpiozero's pin factory on it.

Left to itself gpiozero tries one library after another and falls back in silence, to one
that may not see our other process's claims; and release 2.0.1 opens chip 4 on every Pi 5, which
kernels from 6.6.47 on call chip 0. So library and chip are named outright here.
"""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

from deltactl.foundation.errors import ConfigError

NO_LGPIO = (
    "the package lgpio is missing; type: sudo apt install python3-lgpio (a virtual environment sees"
    " it if made with --system-site-packages, as 'make run' makes it on a Raspberry Pi)"
)
"""PyPI has it up to Python 3.12 only; Raspberry Pi OS 13 has Python 3.13."""

HEADER_CHIPS = ("pinctrl-bcm2835", "pinctrl-bcm2711", "pinctrl-rp1")
"""Labels of the chips behind the 40-pin header: Pi 1 to 3, Pi 4, Pi 5."""
CHIPS = range(10)
"""Numbers that a header's chip may have."""


class NoHeader(Exception):
    """No chip can be used as the header; in one line, with the device."""


def header_chip(gpio: Any, number: int | None) -> tuple[int, int]:
    """Open the chip behind the header: lgpio's handle, and the number of its device.

    number: of the chip, where the robot file names one; None finds it by its label. gpio: lgpio
    or a stand-in. Raises NoHeader.
    """
    refused = []
    for one in CHIPS if number is None else [number]:
        try:
            handle = int(gpio.gpiochip_open(one))
        except gpio.error as error:
            refused.append((one, error))
            continue
        label = str(gpio.gpio_get_chip_info(handle)[3])
        if label.startswith(HEADER_CHIPS):
            return handle, one
        gpio.gpiochip_close(handle)
        refused.append((one, label))
    raise NoHeader(_why_none(refused, number))


def _why_none(refused: list[tuple[int, Any]], number: int | None) -> str:
    """refused: chips, each with the label that it has or the error with which it does not open."""
    others = [f"{device(one)} is '{why}'" for one, why in refused if isinstance(why, str)]
    shut = [
        f"{device(one)} cannot be opened ({why})"
        for one, why in refused
        if not isinstance(why, str) and Path(device(one)).exists()
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
