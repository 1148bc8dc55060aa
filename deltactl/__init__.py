"""Find out where a robot and its model differ, and run a delta robot.

    import deltactl as dc

    recording = dc.read("log.csv", columns={"position": "angle[deg]", "command": "target[deg]"})
    diagnosis = dc.diagnose(recording, "axis.yaml")
    print(diagnosis)

The names in `__all__` are the whole interface; everything else in this package is private and may
change without notice. `config`, `drivers`, `models`, `firmware_py` and `systemd` are folders at the
top of a working copy, and links here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from deltactl.interface.daemon import Client as Client
    from deltactl.interface.daemon import run as run
    from deltactl.interface.diagnoses import Diagnosis as Diagnosis
    from deltactl.interface.diagnoses import diagnose as diagnose
    from deltactl.interface.recordings import Recording as Recording
    from deltactl.interface.recordings import inspect as inspect
    from deltactl.interface.recordings import read as read
    from deltactl.interface.recordings import read_recording as read_recording
    from deltactl.interface.robots import Kinematics as Kinematics
    from deltactl.interface.robots import Robot as Robot
    from deltactl.interface.robots import kinematics as kinematics
    from deltactl.interface.robots import load_robot as load_robot
    from deltactl.interface.simulated import simulate as simulate

    Answer = Diagnosis

__all__ = [
    "Client",
    "Diagnosis",
    "Kinematics",
    "Recording",
    "Robot",
    "diagnose",
    "inspect",
    "kinematics",
    "read",
    "simulate",
]

_PLACES = {
    "Client": "daemon",
    "Diagnosis": "diagnoses",
    "Kinematics": "robots",
    "Recording": "recordings",
    "Robot": "robots",
    "diagnose": "diagnoses",
    "inspect": "recordings",
    "kinematics": "robots",
    "read": "recordings",
    "simulate": "simulated",
}
_OLDER = {
    "Answer": "diagnoses",
    "load_robot": "robots",
    "read_recording": "recordings",
    "run": "daemon",
}
"""Names of version 0.1, which warn and name the new one."""


def __getattr__(name: str) -> Any:
    """Import a part of the interface when it is first used: the pulse process needs none of it."""
    place = _PLACES.get(name) or _OLDER.get(name)
    if place is None:
        raise AttributeError(f"module 'deltactl' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"deltactl.interface.{place}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
