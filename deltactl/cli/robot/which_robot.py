"""The robot file where a command names none: one's own before the example, and it is said."""

from __future__ import annotations

from deltactl.cli.output import warn
from deltactl.firmware_py.robots_here import EXAMPLE, robots_here
from deltactl.foundation.errors import ConfigError


def robot_or_here(named: str | None) -> str:
    """The file that was named, else the only one of this folder, else the example.

    Says on standard error which one is taken. Raises ConfigError where several could be meant.
    """
    if named is not None:
        return named
    here = robots_here()
    if len(here) > 1:
        say = " or ".join(f"--robot {one}" for one in here)
        raise ConfigError(f"{len(here)} robot files are in this folder; add {say}")
    if here:
        warn(f"Robot file: {here[0]}, the one in this folder.")
        return here[0]
    warn(f"Robot file: {EXAMPLE}, the example; --robot names another.")
    return EXAMPLE
