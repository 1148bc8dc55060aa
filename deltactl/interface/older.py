"""Names of version 0.1, kept for one release: each warns, and names the new one."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from deltactl.firmware_py.controller.contract import JobResult
    from deltactl.interface.diagnoses import Diagnosis
    from deltactl.interface.recordings import AnyPath, Columns
    from deltactl.interface.robots import Robot
    from deltactl.models.robot import RobotModel
    from deltactl.recording.tables.flat import FlatRecording

    Answer = Diagnosis

OF_A_RESULT = ("job_id", "name", "outcome", "why", "recording", "recording_error", "warning")


def read_recording(recording: AnyPath, columns: Columns | None = None) -> FlatRecording:
    """Use `read(...).table`."""
    from deltactl.interface.recordings import read

    _warn("read_recording", "read(...), whose .table is what this returns")
    return read(recording, columns).table


def load_robot(robot: AnyPath) -> RobotModel:
    """Use `Robot.load(...).model`."""
    from deltactl.interface.robots import Robot

    _warn("load_robot", "Robot.load(...), whose .model is what this returns")
    return Robot.load(robot).model


def run(job: AnyPath, *, record: AnyPath | None = None, socket: AnyPath | None = None) -> JobResult:
    """Use `Client(...).run(...)`."""
    from deltactl.interface.daemon import Client

    _warn("run", "Client().run(...)")
    with Client(socket) as client:
        return client.run(job, record=record)


class OlderAnswer:
    """What the answer of a diagnosis could do in version 0.1."""

    if TYPE_CHECKING:

        def corrected_robot(self, all_of_them: bool = False) -> Robot:
            """Of a Diagnosis."""

    def save_robot(self, path: AnyPath, replace: bool = False) -> None:
        """Use `corrected_robot().save(path)`."""
        _warn("Diagnosis.save_robot(path)", "Diagnosis.corrected_robot().save(path)")
        self.corrected_robot().save(path, replace)


class OlderResult:
    """What `simulate` returned in version 0.1: how the job ended."""

    ended: JobResult | None

    def __getattr__(self, name: str) -> Any:
        if name not in OF_A_RESULT or self.ended is None:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        _warn(f"simulate(...).{name}", f"simulate(...).ended.{name}")
        return getattr(self.ended, name)


def __getattr__(name: str) -> Any:
    if name != "Answer":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from deltactl.interface.diagnoses import Diagnosis

    _warn("Answer", "Diagnosis")
    return Diagnosis


def _warn(old: str, new: str) -> None:
    warnings.warn(
        f"deltactl.{old} goes with the next release; use deltactl.{new}", DeprecationWarning, 3
    )
