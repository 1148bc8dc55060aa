"""A simulated robot behind a daemon's socket, in this process and by the real clock.

The robot's file is named otherwise than the robot. Does not model: a daemon of its own process.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from deltactl.firmware_py.controller.build import simulated_machine
from deltactl.firmware_py.controller.controller import Controller
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.server import Server
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import load_robot


@dataclass(frozen=True)
class Served:
    """The controller, and the socket at which it is asked."""

    controller: Controller
    socket: Path

    def ready(self) -> None:
        """End the fault that a stall of this computer is, which would stay latched."""
        if self.controller.status().state == State.FAULT.value:
            self.controller.acknowledge()
            self.controller.home()


@contextmanager
def served(folder: Path, shipped: str = "gripper-delta.yaml") -> Iterator[Served]:
    """A robot that is homed; shipped: the robot file of the package that it has."""
    robot = folder / "mine.yaml"
    shutil.copy(CONFIG_FOLDER / shipped, robot)
    # Not build_controller: it freezes what the collector knows, for this process's whole life.
    described = load_robot(robot)
    controller = Controller(described, robot, simulated_machine(described, True), folder)
    server = Server(controller, Listener(folder / "socket"), folder / "jobs", folder)
    server.start()
    controller.power_on()
    controller.home()
    try:
        yield Served(controller, folder / "socket")
    finally:
        server.close()
        controller.close()
