"""The page's one ear at the daemon: the newest status, however many browsers look at it."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deltactl.firmware_py.controller.contract import JobResult, Status
from deltactl.firmware_py.daemon.client import Client
from deltactl.foundation.errors import DeltactlError, ServiceError

RATE_HZ = 20.0
"""As often as the daemon's protocol allows."""
RETRY_S = 0.5
STALE_S = 1.0
"""A status older than this is shown as old."""
NOISE_OF = 60
"""Readings from which the noise of a sensor is estimated: three seconds."""


@dataclass(frozen=True, slots=True)
class Seen:
    """What was heard last. `status` is None while no daemon answers; `problem` says why."""

    serial: int
    at_s: float
    status: Status | None
    problem: str
    noise_m: tuple[float | None, ...] = ()
    """Standard deviation of each sensor's readings."""
    ended: JobResult | None = None
    """How the newest job that was seen to run has ended."""

    @property
    def age_s(self) -> float:
        """How old it is."""
        return time.monotonic() - self.at_s


class DaemonLink:
    """Watches the daemon in a thread of its own, and carries requests to it.

    When the daemon goes away it is looked for again, twice a second.
    """

    def __init__(self, socket: Path | None = None, rate_hz: float = RATE_HZ):
        self._socket, self._rate_hz = socket, rate_hz
        self._seen = Seen(0, time.monotonic(), None, "looking for the daemon")
        self._distances: list[deque[float]] = []
        self._ran: int | None = None
        """Number of the job that was last seen to run, until it is known how it has ended."""
        self.on_status: Callable[[Status, JobResult | None], None] | None = None
        """Hears every status, and how the newest job ended, in the watching thread."""
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="watch", daemon=True)
        self._owning: Client | None = None
        """Whose jobs those of all pages are: they end with this process, not with a request."""
        self._owning_turn = threading.Lock()

    def start(self) -> None:
        """Begin to watch."""
        self._thread.start()

    def close(self) -> None:
        """End watching, and every job that a page has sent."""
        self._ending.set()
        if self._owning is not None:
            self._owning.close()

    @property
    def seen(self) -> Seen:
        """The newest status."""
        return self._seen

    @contextmanager
    def client(self) -> Iterator[Client]:
        """A connection of its own for a request. Raises what the daemon answers."""
        with Client(self._socket) as client:
            yield client

    def place(self) -> Path:
        """The socket at which the daemon answers. Raises ServiceError."""
        with self.client() as client:
            return client.path

    def submit_text(self, text: str, name: str) -> int:
        """Check and queue a job. Raises what the daemon answers."""
        return self._owner().submit_text(text, name)

    def _owner(self) -> Client:
        """The connection that jobs belong to; a new one where the daemon has ended it."""
        with self._owning_turn:
            if self._owning is not None:
                try:
                    self._owning.progress_count()
                except DeltactlError:
                    self._owning.close()
                    self._owning = None
            if self._owning is None:
                self._owning = Client(self._socket)
            return self._owning

    def stop(self, reason: str) -> None:
        """Emergency stop."""
        with self.client() as client:
            client.stop(reason)

    def _watch(self) -> None:
        while not self._ending.is_set():
            try:
                with self.client() as client:
                    for status in client.watch(self._rate_hz):
                        self._note(status, self._ended(client, status))
                        if self._ending.is_set():
                            return
            except DeltactlError as error:
                self._lost(str(error))
            except OSError as error:
                self._lost(str(ServiceError(error)))
            self._ending.wait(RETRY_S)

    def _ended(self, client: Client, status: Status) -> JobResult | None:
        """How the newest job has ended; asked for once, when its recording is closed."""
        ran, ended = self._ran, self._seen.ended
        if ran is not None and status.job_id != ran:
            with suppress(ServiceError):  # a daemon that was started anew knows no such job
                if (result := client.result(ran)) is None:
                    return ended
                ended = result
            self._ran = None
        if status.job_id is not None:
            self._ran = status.job_id
        return ended

    def _note(self, status: Status, ended: JobResult | None) -> None:
        if len(self._distances) != len(status.sensors):
            self._distances = [deque(maxlen=NOISE_OF) for _ in status.sensors]
        for kept, sensor in zip(self._distances, status.sensors, strict=True):
            if sensor.distance_m is not None and sensor.gate == "good":
                kept.append(sensor.distance_m)
        if self.on_status is not None:
            self.on_status(status, ended)
        noise_m = tuple(_noise(kept) for kept in self._distances)
        self._seen = Seen(self._seen.serial + 1, time.monotonic(), status, "", noise_m, ended)

    def _lost(self, problem: str) -> None:
        self._distances = []
        self._seen = Seen(self._seen.serial + 1, time.monotonic(), None, problem)


def _noise(distances_m: deque[float]) -> float | None:
    """Standard deviation by differences of neighbours, so that slow motion hardly counts."""
    if len(distances_m) < NOISE_OF // 2:
        return None
    steps = np.abs(np.diff(np.array(distances_m)))
    # Median of |a - b| of two normal values is 0.6745 sqrt(2) times their standard deviation.
    return float(np.median(steps) / (0.6745 * np.sqrt(2.0)))
