"""Names of version 0.1, kept for one release: each warns, and names the new one."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

from deltactl.interface.daemon import Client
from deltactl.interface.diagnoses import Diagnosis as Answer
from deltactl.interface.recordings import AnyPath, Columns, read
from deltactl.interface.robots import Robot

if TYPE_CHECKING:
    from deltactl.firmware_py.controller.contract import JobResult
    from deltactl.models.robot import RobotModel
    from deltactl.recording.tables.flat import FlatRecording

__all__ = ["Answer", "load_robot", "read_recording", "run"]


def read_recording(recording: AnyPath, columns: Columns | None = None) -> FlatRecording:
    """Use `read(...).table`."""
    _warn("read_recording", "read(...), whose .table is what this returns")
    return read(recording, columns).table


def load_robot(robot: AnyPath) -> RobotModel:
    """Use `Robot.load(...).model`."""
    _warn("load_robot", "Robot.load(...), whose .model is what this returns")
    return Robot.load(robot).model


def run(job: AnyPath, *, record: AnyPath | None = None, socket: AnyPath | None = None) -> JobResult:
    """Use `Client(...).run(...)`."""
    _warn("run", "Client().run(...)")
    with Client(socket) as client:
        return client.run(job, record=record)


def _warn(old: str, new: str) -> None:
    warnings.warn(
        f"deltactl.{old} goes with the next release; use deltactl.{new}", DeprecationWarning, 3
    )
