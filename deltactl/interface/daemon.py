"""The robot of the daemon, as a notebook moves it."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from deltactl.firmware_py.daemon.client import Client as Line
from deltactl.firmware_py.named_files import JOB_KEY, find
from deltactl.foundation.errors import ConfigError, NotReady
from deltactl.interface import older

if TYPE_CHECKING:
    from deltactl.firmware_py.controller.contract import HomeSeen, JobResult, Status
    from deltactl.interface.recordings import AnyPath

POLL_S = 0.5
SPEED_MPS = 0.02


class Client:
    """The daemon that runs the robot: one connection, which is a context manager.

    Jobs that this connection has begun end with it: the robot decelerates.

    Parameters
    ----------
    socket : path, optional
        The daemon's socket; without it the usual places are tried.

    Raises
    ------
    ServiceError
        From any method: no daemon answers, or it may not be used.

    Examples
    --------
    >>> import deltactl as dc
    >>> with dc.Client() as robot:                                  # doctest: +SKIP
    ...     robot.jog(z_m=-0.005)
    ...     for now in robot.status(rate_hz=2.0):
    ...         print(now.state, now.position_m)
    """

    def __init__(self, socket: AnyPath | None = None):
        self._line = Line(None if socket is None else Path(socket))

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def power_on(self) -> None:
        """Energise the drives."""
        self._line.power_on()

    def power_off(self) -> None:
        """Release the drives."""
        self._line.power_off()

    def home(self) -> HomeSeen:
        """Learn where the arms are; put them against their stops first.

        Returns what the sensors said. Raises NotReady, or SensorFault where they disagree.
        """
        return self._line.home()

    def run(self, job: AnyPath, *, record: AnyPath | None = None) -> JobResult:
        """Run a job and wait for its end.

        An interruption (Ctrl-C, the stop button of a notebook) cancels it: the robot decelerates.

        Parameters
        ----------
        job : path
            The job file.
        record : path, optional
            A name in the daemon's folder of recordings.

        Returns
        -------
        JobResult
            `outcome` is 'done', 'cancelled', 'stopped', 'fault' or 'refused', and `why` says why.

        Raises
        ------
        ConfigError, MotionError, NotReady
            What the daemon refuses the job with; nothing has moved.
        """
        path = find(str(job), key=JOB_KEY)
        name = None if record is None else Path(record)
        return self._ended(self._line.submit(path.resolve(), name))

    def jog(
        self, x_m: float = 0.0, y_m: float = 0.0, z_m: float = 0.0, *, speed_mps: float = SPEED_MPS
    ) -> JobResult:
        """Move the platform by a little from where it is, in a straight line, and wait.

        Parameters
        ----------
        x_m, y_m, z_m : float, optional
            By how much [m].
        speed_mps : float, optional
            Greatest speed [m/s].

        Raises
        ------
        NotReady
            The position is unknown (home first), or a job runs.
        LimitExceeded, UnreachablePoint
            The way leaves the robot's limits; nothing has moved.
        """
        if not (x_m or y_m or z_m):
            raise ConfigError("jog: say how far: x_m, y_m or z_m")
        now = self._line.status()
        if now.state in ("planning", "running", "paused"):
            raise NotReady(f"jog: the robot is {now.state}; wait for the job's end")
        if now.position_m is None:
            raise NotReady(f"jog: the position is unknown ({now.why or now.state}); home first")
        goal = [here + by for here, by in zip(now.position_m, (x_m, y_m, z_m), strict=True)]
        job = {
            "name": "jog",
            "robot": now.robot_file,
            "path": {"shape": "straight", "to_m": goal},
            "timing": {"mode": "accelerated", "speed_mps": speed_mps},
            "inverse_kinematics": {"kind": "geometry"},
        }
        return self._ended(self._line.submit_text(json.dumps(job), "jog.yaml"))

    def status(self, rate_hz: float = 5.0) -> Iterator[Status]:
        """State, position, job and sensors, again and again until the caller stops asking.

        Parameters
        ----------
        rate_hz : float, optional
            How often a second. `next(client.status())` is the status now.

        Yields
        ------
        Status
            `state`, `position_m` (None while unknown), `job`, `progress`, `sensors`, ...
        """
        yield self._line.status()
        yield from self._line.watch(rate_hz)

    def stop(self, reason: str = "stop requested") -> None:
        """Emergency stop, past everything that is under way; from any thread."""
        self._line.stop(reason)

    def acknowledge(self) -> None:
        """Accept an emergency stop or fault whose cause is gone; home afterwards."""
        self._line.acknowledge()

    def close(self) -> None:
        """End the connection, and with it the job that it has begun."""
        self._line.close()

    def _ended(self, number: int) -> JobResult:
        while (result := self._line.result(number)) is None:
            try:
                time.sleep(POLL_S)
            except KeyboardInterrupt:
                self._line.cancel(number)
        return result


def run(job: AnyPath, *, record: AnyPath | None = None, socket: AnyPath | None = None) -> JobResult:
    """Use `Client(...).run(...)`; this name goes."""
    older("run")
    with Client(socket) as client:
        return client.run(job, record=record)
