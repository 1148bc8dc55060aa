"""gpiozero's pin factory for the pins of this Pi, named outright.

Left to itself gpiozero tries one library after another and falls back in silence, to one
that may not see our other process's claims.
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


def lgpio_pin_factory() -> Any:
    """A gpiozero LGPIOFactory. Raises ConfigError when this machine has no usable GPIO."""
    here = Path.cwd()
    os.environ.setdefault("LG_WD", os.environ.get("RUNTIME_DIRECTORY") or _private_folder())
    try:
        from gpiozero.pins.lgpio import LGPIOFactory

        return LGPIOFactory()
    except ImportError as error:
        raise ConfigError(NO_LGPIO) from error
    except Exception as error:  # lgpio.error, PinUnknownPi and OSError have no common root
        raise ConfigError(f"the GPIO pins of this machine cannot be used: {error}") from error
    finally:
        os.chdir(here)  # importing lgpio changes into LG_WD


def _private_folder() -> str:
    """Where lgpio may leave its notification pipe while this process lives."""
    folder = tempfile.mkdtemp(prefix="deltactl-lgpio-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder
