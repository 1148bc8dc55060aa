"""Jobs on a simulated robot, with faults that its robot file does not have."""

from __future__ import annotations

import json
import re
import tempfile
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.named_files import JOB_KEY, ROBOT_KEY, find
from deltactl.foundation.errors import ConfigError, MotionError
from deltactl.foundation.strict_yaml import Document
from deltactl.interface.recordings import AnyPath, Recording
from deltactl.interface.robots import Robot, robot_of
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.rounds import flatten, flatten_unseen, has_readings

Job = AnyPath | Mapping[str, Any]
Fault = Mapping[str, Any]
"""An entry as in `effects` of a robot file: effect, component, parameters."""

POLL_S = 0.5
ANY_DEG = 360.0
"""Homing of a simulated robot puts the arms exactly where they count as homed."""


def simulate(
    job: Job,
    robot: AnyPath | Robot | None = None,
    *,
    faults: Sequence[Fault] = (),
    seed: int | None = None,
    record: AnyPath | None = None,
) -> Recording:
    """Run a job on a simulated delta, faster than real time, and return what was recorded.

    Parameters
    ----------
    job : path or mapping
        The job file, or what it says, such as `diagnosis.next_experiment.job`.
    robot : Robot or path, optional
        In place of the job's own robot file. A corrected robot that was never saved will do.
    faults : sequence of mappings, optional
        Everything in which the simulated robot differs from its design, each as an entry of
        `effects` in a robot file: `{"effect": "gear_backlash", "component": "motor2",
        "parameters": {"width": 0.008}}`. docs/reference/effects.md lists them. The robot file
        learns nothing of them. Without any the simulated robot is as its file says, `effects`
        included.
    seed : int, optional
        Of the simulated sensors' noise.
    record : path, optional
        Where the recorded run (`.mcap`) is kept; without it no file is left.

    Returns
    -------
    Recording
        Commands and readings in SI units; `ended` says how the job ended. Beside them are columns
        that a diagnosis does not read: where the platform truly was (`truth_x_m`, ...), and the
        true angles of the arms (`truth_theta_1_rad`, ...).

    Raises
    ------
    ConfigError, MissingFile, MotionError
        Before anything moves: a file or fault is wrong, or the job breaks a limit.

    Warns
    -----
    RuntimeWarning
        The job did not run to its end.
    """
    from deltactl.firmware_py.controller.build import build_controller
    from deltactl.firmware_py.planning.prepared import Readers
    from deltactl.foundation.clock import sleep_s

    files = FileAccess()
    path = _job_file(job, robot, files)
    robot_file = _robot_file(path, robot, files)
    with tempfile.TemporaryDirectory() as folder, _as_built(faults) as built:
        controller = build_controller(
            robot_file,
            simulated=True,
            realtime=False,
            recordings=Path(folder),
            seed=seed,
            readers=Readers(before=files),
            as_built=built,
        )
        try:
            controller.power_on()
            controller.home(ANY_DEG)
            number = controller.submit(path, None if record is None else Path(record))
            while (result := controller.result(number)) is None:
                sleep_s(controller.clock, POLL_S)
                if controller.status().state == "paused":
                    controller.resume()  # nobody else could
        finally:
            controller.close()
        return _recorded(result, record is not None)


def _job_file(job: Job, robot: AnyPath | Robot | None, files: FileAccess) -> Path:
    """The job's file; of a mapping one that is nowhere but in `files`, beside the robot's."""
    if not isinstance(job, Mapping):
        return find(str(job), key=JOB_KEY)
    path, named = Path("job.yaml").absolute(), dict[str, Any]()
    if robot is not None:
        file = robot_of(robot).path.absolute()
        path, named = file.with_name("job.yaml"), {"robot": file.name}
    text = json.dumps(dict(job) | named)
    files.once("document", path, lambda: Document(path, text))
    return path


def _robot_file(job: Path, robot: AnyPath | Robot | None, files: FileAccess) -> Path:
    """The robot's file; of a robot that was never saved one that is nowhere but in `files`."""
    from deltactl.firmware_py.program.includes import job_of

    if robot is None:
        return find(job_of(job, files).robot, beside=job, key=ROBOT_KEY)
    one = robot_of(robot)
    files.once("document", one.path, lambda: one.document)
    return one.path


@contextmanager
def _as_built(faults: Sequence[Fault]) -> Iterator[Path | None]:
    """A file apart that says what the simulated robot is really like; none without faults."""
    if not faults:
        yield None
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "faults"
        text = json.dumps({"effects": [_plain(fault) for fault in faults]})
        path.write_text(text, encoding="utf-8")
        try:
            yield path
        except ConfigError as error:
            raise error.worded(
                re.sub(rf"{re.escape(str(path))}(:1)?", "faults", str(error))
            ) from None


def _plain(fault: Fault) -> dict[str, Any]:
    if not isinstance(fault, Mapping):
        raise ConfigError(
            f"faults: {fault!r} is no entry such as"
            ' {"effect": "gear_backlash", "component": "motor2", "parameters": {"width": 0.008}}'
        )
    return dict(fault)


def _recorded(result: JobResult, kept: bool) -> Recording:
    if result.recording is None:
        raise MotionError(
            f"{result.name}: {result.outcome}: {result.why or result.recording_error}"
        )
    if result.outcome != "done":
        warnings.warn(f"{result.name}: {result.outcome}: {result.why}", RuntimeWarning, 3)
    run = read_run(Path(result.recording))
    table = flatten(run, True) if has_readings(run) else flatten_unseen(run, True)
    return Recording(table if kept else replace(table, source=result.name), ended=result)
