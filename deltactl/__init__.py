"""Run a delta robot, and find out where a robot and its model differ.

    import deltactl

    answer = deltactl.diagnose("log.csv", robot="axis.yaml",
                               columns={"position": "angle[deg]", "command": "target[deg]"})
    print(answer)

`diagnose`, `inspect`, `read_recording`, `load_robot`, `run` and `simulate` are the whole interface;
everything else in this package may change without notice. `config`, `drivers`, `models`,
`firmware_py` and `systemd` are folders at the top of a working copy, and links here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from deltactl.interface import Answer as Answer
    from deltactl.interface import diagnose as diagnose
    from deltactl.interface import inspect as inspect
    from deltactl.interface import load_robot as load_robot
    from deltactl.interface import read_recording as read_recording
    from deltactl.interface import run as run
    from deltactl.interface import simulate as simulate

__all__ = ["Answer", "diagnose", "inspect", "load_robot", "read_recording", "run", "simulate"]


def __getattr__(name: str) -> Any:
    """Import the interface when it is first used: the pulse process needs none of it."""
    if name not in __all__:
        raise AttributeError(f"module 'deltactl' has no attribute {name!r}")
    from deltactl import interface

    return getattr(interface, name)


def __dir__() -> list[str]:
    return sorted(__all__)
