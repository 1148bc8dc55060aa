"""An in-memory controller with the real table of states, and a daemon served from it."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.claim import CLIENT_WENT, Claim, Owner
from deltactl.firmware_py.controller.contract import HomeSeen, JobResult, SensorStatus, Status
from deltactl.firmware_py.controller.states import Request, State, require
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.daemon.limits import Limits
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.server import Server
from deltactl.foundation.errors import ConfigError, NotReady, ServiceError


@dataclass
class MemoryJob:
    number: int
    name: str
    path: Path
    record: Path | None
    left_s: float
    claim: Claim = field(default_factory=Claim)
    outcome: str = ""
    why: str = ""


@dataclass
class MemoryController:
    """States, queue and results of a controller; a job is nothing but a duration.

    Does not model: pulses, sensors, files (a job's text is "duration: seconds"), faults.
    """

    home_s: float = 0.0
    state: State = State.OFF
    why: str = ""
    jobs: list[MemoryJob] = field(default_factory=list)
    calls: list[str] = field(default_factory=list)
    lock: threading.RLock = field(default_factory=threading.RLock)
    frozen: bool = False
    closed: bool = False
    lost: str = ""
    let_go: threading.Event = field(default_factory=threading.Event)
    """Homing and checking a job wait for it; set, unless a test clears it."""
    _count: int = 0
    _numbers: int = 0
    _at_s: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.let_go.set()

    def power_on(self) -> None:
        self._request(Request.ON, State.UNHOMED)

    def power_off(self) -> None:
        self._request(Request.OFF, State.OFF)

    def home(
        self,
        accept_unseen_deg: float = 0.0,
        robot: Path | None = None,
        claim: Claim | None = None,
        trial: bool = False,
    ) -> HomeSeen:
        self._request(Request.HOME, State.HOMING)
        time.sleep(self.home_s)
        self.let_go.wait(30.0)
        with self.lock:
            if self.state is not State.HOMING:
                raise NotReady("cannot home: called off")
            self.state = State.READY
        return HomeSeen(f"taken on trust to {accept_unseen_deg:g} degrees", "look")

    def fatal(self) -> str:
        return self.lost

    def submit(self, job: Path, record: Path | None = None) -> int:
        claim = Claim()
        self.accept(job, claim)
        self.check(job, record, claim)
        return claim.number

    def accept(self, job: Path, claim: Claim) -> None:
        with self.lock:
            require(Request.RUN, self.state, self.why)
            self._numbers += 1
            claim.number = self._numbers

    def check(self, job: Path, record: Path | None, claim: Claim) -> None:
        self.let_go.wait(30.0)
        claim.must_hold("run")
        text = job.read_text()
        if not text.startswith("duration: "):
            raise ConfigError(f"{job}:1: 'duration' is missing")
        with self.lock:
            self.calls.append("run")
            self.jobs.append(
                MemoryJob(claim.number, job.stem, job, record, float(text[10:]), claim)
            )
            claim.accepted()

    def move(self, job_id: int, place: int) -> None:
        with self.lock:
            found = next((job for job in self.jobs[1:] if job.claim.number == job_id), None)
            if found is None:
                raise NotReady(f"job {job_id} does not wait")
            self.jobs.remove(found)
            self.jobs.insert(place, found)

    def leave(self, owner: Owner) -> None:
        with self.lock:
            owner.gone = True
            for one in self.jobs:
                if one.claim.owner is owner and not one.outcome:
                    one.outcome, one.why = "cancelled", CLIENT_WENT

    def owes(self, owner: Owner) -> bool:
        with self.lock:
            self._go_on()
            return any(one.claim.owner is owner and not one.outcome for one in self.jobs)

    def pause(self) -> None:
        self._request(Request.PAUSE, State.PAUSED)

    def resume(self) -> None:
        self._request(Request.RESUME, State.RUNNING)

    def cancel(self, job_id: int | None = None) -> None:
        self._request(Request.CANCEL, State.READY)
        self._end_all("cancelled")

    def stop(self, reason: str) -> None:
        self.calls.append("stop")
        with self.lock:
            self.state, self.why = State.STOPPED, reason
            self._end_all("stopped")

    def acknowledge(self) -> None:
        self._request(Request.ACKNOWLEDGE, State.UNHOMED)

    def status(self) -> Status:
        with self.lock:
            self._go_on()
            job = next((one for one in self.jobs if not one.outcome), None)
            return Status(
                state=self.state.value,
                why=self.why,
                robot="memory",
                simulated=True,
                time_s=time.monotonic(),
                counts=(1, 2, 3),
                angles_rad=(0.1, 0.2, 0.3) if self.state is State.READY else None,
                position_m=(0.0, float("nan"), -0.4),
                job=job.name if job else None,
                job_id=job.number if job else None,
                progress=0.5,
                seconds_left=job.left_s if job else None,
                queued=tuple(one.name for one in self.jobs if not one.outcome)[1:],
                recording=None,
                recording_error="",
                late_ns=0,
                sensors=(SensorStatus("x", 0.4, 0.01, "good", 9.5, "ok"),),
            )

    def result(self, job_id: int) -> JobResult | None:
        with self.lock:
            self._go_on()
            if not 0 < job_id <= self._numbers:
                raise ServiceError(f"the daemon knows no job {job_id}")
            job = next((one for one in self.jobs if one.number == job_id), None)
            if job is None or not job.outcome:
                return None
            return JobResult(job.number, job.name, job.outcome, job.why or self.why, None)

    def progress_count(self) -> int:
        self._count += not self.frozen
        return self._count

    def close(self) -> None:
        self.closed = True

    def _request(self, request: Request, then: State) -> None:
        with self.lock:
            self._go_on()
            require(request, self.state, self.why)
            self.calls.append(request.value)
            self.state, self.why = then, ""

    def _go_on(self) -> None:
        """Let the time since the last look pass."""
        now_s = time.monotonic()
        passed_s, self._at_s = now_s - self._at_s, now_s
        waiting = [job for job in self.jobs if not job.outcome]
        if self.state in (State.READY, State.RUNNING):
            self.state = State.RUNNING if waiting else State.READY
        if self.state is State.RUNNING and waiting:
            waiting[0].left_s -= passed_s
            if waiting[0].left_s <= 0.0:
                waiting[0].outcome = "done"

    def _end_all(self, outcome: str) -> None:
        for job in self.jobs:
            job.outcome = job.outcome or outcome


class RawClient:
    """A socket and nothing else, to say what a well-behaved client would not."""

    def __init__(self, path: Path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.settimeout(30.0)
        self.socket.connect(str(path))
        self._file = self.socket.makefile("rb")

    def send(self, raw: bytes) -> None:
        self.socket.sendall(raw)

    def receive(self) -> dict[str, object] | None:
        """The next answer; None at the end of the connection."""
        line = self._file.readline()
        return json.loads(line) if line else None

    def ask(self, **request: object) -> dict[str, object] | None:
        self.send(json.dumps(request).encode() + b"\n")
        return self.receive()

    def close(self) -> None:
        self._file.close()
        self.socket.close()


@dataclass
class Daemon:
    """A served controller and everything needed to talk to it."""

    controller: MemoryController
    server: Server
    path: Path
    notes: list[str]
    _opened: list[RawClient] = field(default_factory=list)

    def client(self) -> Client:
        return Client(self.path)

    def raw(self) -> RawClient:
        self._opened.append(RawClient(self.path))
        return self._opened[-1]

    def close(self) -> None:
        for client in self._opened:
            client.close()
        self.server.close()


Serve = Callable[..., Daemon]


@pytest.fixture
def serve(tmp_path: Path) -> Iterator[Serve]:
    """Start daemons: `serve(Limits(...), start=..., home_s=...)`."""
    daemons: list[Daemon] = []

    def make(limits: Limits | None = None, start: bool = True, **options: float) -> Daemon:
        controller, notes = MemoryController(**options), []
        path = tmp_path / "d.sock"
        server = Server(
            controller, Listener(path), tmp_path / "jobs", tmp_path, notes.append, limits
        )
        daemons.append(Daemon(controller, server, path, notes))
        if start:
            server.start()
        return daemons[-1]

    yield make
    for daemon in daemons:
        daemon.close()


@pytest.fixture
def wait_until() -> Callable[..., None]:
    """Wait for something that happens in another thread; fail when it does not."""

    def wait(condition: Callable[[], bool], limit_s: float = 30.0) -> None:
        give_up_s = time.monotonic() + limit_s
        while not condition():
            assert time.monotonic() < give_up_s, f"did not happen within {limit_s:g} s"
            time.sleep(0.005)

    return wait


@pytest.fixture
def job(tmp_path: Path) -> Path:
    """A job of a tenth of a second."""
    path = tmp_path / "circle.yaml"
    path.write_text("duration: 0.1")
    return path
