"""The robot that is healed: through its daemon, or simulated in this process."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from deltactl.firmware_py.controller.build import build_controller
from deltactl.firmware_py.controller.contract import JobResult, Status
from deltactl.firmware_py.controller.sensing.verify import good_ranges_m
from deltactl.firmware_py.controller.states import State
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.run_report.reference import targets_at
from deltactl.foundation.clock import sleep_s
from deltactl.foundation.errors import ConfigError, MotionError
from deltactl.models.robot import AXES
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.rounds import flatten
from deltactl.repair.compared import Seen

LOOK_S = 2.0
POLL_S, VIRTUAL_POLL_S = 0.1, 0.5
ANY_DEG = 360.0
"""Homing of a simulated robot puts the arms exactly where they count as homed."""
Sleep = Callable[[float], None]


class Homed(NamedTuple):
    """What the sensors said at home, and how much one reading scatters there [m]."""

    text: str
    noise_m: float


class Ran(NamedTuple):
    """A recording, and how long the robot took for it."""

    recording: Path
    seconds: float


class Patient(Protocol):
    """What a healing asks of a robot. Everything raises DeltactlError where it cannot be had."""

    def home(self, robot_file: Path) -> Homed:
        """Home by a robot file, which is in force from then on; sensors must agree with it."""
        ...

    def run(self, job: Path, robot_file: Path, record: Path) -> Ran:
        """Home, and run a job to its end by a robot file; `record` has no ending."""
        ...

    def seen(self, recording: Path, job: Path, robot_file: Path) -> Seen:
        """A drawing as it was recorded."""
        ...


class Controlled(Protocol):
    """What a controller in this process and a daemon's client have in common."""

    def submit(self, job: Path, record: Path | None = None) -> int: ...
    def result(self, job_id: int) -> JobResult | None: ...
    def resume(self) -> None: ...
    def status(self) -> Status: ...


class SimulatedPatient:
    """A simulated robot, built anew for each run; its faults are in `as_built` of the file."""

    def __init__(self, folder: Path):
        """folder: for its recordings."""
        self._folder, self._runs = folder, 0

    def home(self, robot_file: Path) -> Homed:
        """See Patient."""
        with self._controller(robot_file) as (controller, sleep, said):
            return Homed(said, noise_m(controller, sleep))

    def run(self, job: Path, robot_file: Path, record: Path) -> Ran:
        """See Patient."""
        with self._controller(robot_file) as (controller, sleep, _):
            return _followed(controller, job, record.with_suffix(".mcap"), sleep, VIRTUAL_POLL_S)

    def seen(self, recording: Path, job: Path, robot_file: Path) -> Seen:
        """See Patient."""
        return seen_in(recording)

    @contextmanager
    def _controller(self, robot_file: Path) -> Iterator[tuple[Controlled, Sleep, str]]:
        self._runs += 1
        controller = build_controller(
            robot_file,
            simulated=True,
            realtime=False,
            recordings=self._folder,
            seed=self._runs,
        )
        try:
            controller.power_on()
            said = controller.home(ANY_DEG)
            yield controller, lambda seconds: sleep_s(controller.clock, seconds), said.says()
        finally:
            controller.close()


class DaemonPatient:
    """The robot of a daemon. What moves, and a file on trial, end with the connection of a call."""

    def __init__(self, socket: Path | None, robot_file: Path):
        """Raises ConfigError where the daemon runs another robot file."""
        self._socket, self._in_force = socket, robot_file
        with Client(socket) as client:
            runs = client.status().robot_path
        if Path(runs).resolve() != robot_file.resolve():
            raise ConfigError(
                f"{robot_file}: the daemon runs {runs}; heal that one, or use --simulate"
            )

    def home(self, robot_file: Path) -> Homed:
        """See Patient."""
        with Client(self._socket) as client:
            if client.status().state == State.OFF.value:
                client.power_on()
            said = client.home(robot=robot_file)
            return Homed(said.says(), noise_m(client, time.sleep))

    def run(self, job: Path, robot_file: Path, record: Path) -> Ran:
        """See Patient; the daemon names the recording, and ends with its own file in force."""
        on_trial = robot_file != self._in_force
        with Client(self._socket) as client:
            if client.status().state == State.OFF.value:
                client.power_on()
            client.home(robot=robot_file, trial=on_trial)
            tried = client.status().robot_path
            ran = _followed(client, job, None, time.sleep, POLL_S)
            if client.status().robot_path != tried:
                raise MotionError(f"{job.name}: somebody homed the robot by another file meanwhile")
            if on_trial:
                client.home(robot=self._in_force)
            return ran

    def seen(self, recording: Path, job: Path, robot_file: Path) -> Seen:
        """See Patient."""
        return seen_in(recording)


def noise_m(controller: Controlled, sleep: Sleep) -> float:
    """Standard deviation of one reading at rest, of the worst sensor [m]. Raises NotReady."""
    seen_m = good_ranges_m(controller.status, sleep, LOOK_S)
    return max(float(np.std(values, ddof=1)) for values in seen_m.values())


def _followed(
    controller: Controlled, job: Path, record: Path | None, sleep: Sleep, every_s: float
) -> Ran:
    """Run a job to its end. Raises MotionError where it ends otherwise."""
    begun_s = controller.status().time_s
    number = controller.submit(job, record)
    while (result := controller.result(number)) is None:
        sleep(every_s)
        status = controller.status()
        if status.simulated and status.state == State.PAUSED.value:
            controller.resume()  # nobody else could
    if result.outcome != "done" or result.recording is None:
        raise MotionError(f"{result.name}: {result.outcome}: {result.why or 'not recorded'}")
    return Ran(Path(result.recording), controller.status().time_s - begun_s)


def seen_in(recording: Path) -> Seen:
    """A drawing in a recorded run. Raises RecordingError."""
    run = read_run(recording)
    table = flatten(run)
    targets = [targets_at(run, table.extra[f"t_{axis}"]) for axis in AXES]
    return Seen(table, np.stack(targets, axis=1))
