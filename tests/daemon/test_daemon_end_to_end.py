"""The daemon as systemd starts it: a process of its own, a simulated robot in real time.

The pulse process and its lines are the real code; only drives and sensors are simulated, in
memory that this test looks into from outside.
"""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from mmap import mmap
from pathlib import Path

import numpy as np
import pytest

from deltactl.drivers.fakes.lines import BENCH_BYTES, BenchMemory
from deltactl.drivers.settings import StepSettings
from deltactl.firmware_py.daemon.client import Client
from deltactl.firmware_py.install.steps import PROGRAM
from deltactl.foundation.errors import NotReady, ServiceError
from deltactl.recording.reading.reader import read_run
from deltactl.recording.reading.run import Run
from tests.rigs.faults.daemon_stand import pulse_process_of

ROBOT_FILE = PROGRAM / "config/zhao-2023.yaml"
HEARTBEAT_S = StepSettings().heartbeat_s
MINIMUM_GAP = StepSettings().minimum_gap_fraction
NO_EXECUTABLE_MEMORY = (
    "import ctypes, sys; ctypes.CDLL(None).prctl(65, 1, 0, 0, 0);"
    "from deltactl.cli.main import main; main()"
)
"""PR_SET_MDWE, which is what MemoryDenyWriteExecute= of the unit does (kernels from 6.3 on)."""

START_S = 60.0
"""TimeoutStartSec of the unit."""
T_PWM_NS = 500_000
HEART = """
name: heart
robot: zhao-2023.yaml
path: {{shape: heart, centre_m: [0.0, 0.0, -0.4], width_m: {width_m}, turns: {turns}}}
timing: {{mode: together, t_pwm_s: 0.0005}}
inverse_kinematics: {{kind: network, file: zhao-2023.tflite}}
"""


class Manager:
    """The service manager's end of NOTIFY_SOCKET; like systemd, it reads all the time."""

    def __init__(self, path: Path):
        self.heard: list[str] = []
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(path))
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._socket.close()

    def _listen(self) -> None:
        while message := self._socket.recv(4096):
            self.heard.append(message.decode())


@dataclass
class Process:
    """The daemon's process, and the ends of everything it is connected to."""

    process: subprocess.Popen[bytes]
    manager: Manager
    folder: Path

    @property
    def socket(self) -> Path:
        return self.folder / "d.sock"

    def job(self, width_m: float, turns: int) -> Path:
        path = self.folder / "heart.yaml"
        path.write_text(HEART.format(width_m=width_m, turns=turns))
        return path

    def bench(self) -> BenchMemory:
        """The memory in which the simulated drives note every step; outlives both processes."""
        folder = Path(f"/proc/{self.process.pid}/fd")
        found = next(one for one in folder.iterdir() if "deltactl-bench" in os.readlink(one))
        descriptor = os.open(found, os.O_RDWR)
        try:
            return BenchMemory(mmap(descriptor, BENCH_BYTES))
        finally:
            os.close(descriptor)

    def pulse_process(self) -> int:
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        return pulse_process_of([int(child) for child in children.read_text().split()])


WaitUntil = Callable[..., None]


@pytest.fixture
def daemon(tmp_path: Path, wait_until: WaitUntil) -> Iterator[Process]:
    """Started and READY, with a watchdog limit of two seconds."""
    manager = Manager(tmp_path / "notify")
    environment = os.environ | {
        "NOTIFY_SOCKET": str(tmp_path / "notify"),
        "WATCHDOG_USEC": "2000000",
        "STATE_DIRECTORY": str(tmp_path / "state"),
        "PYTHONWARNINGS": "error",
    }
    options = {"--recordings": tmp_path / "recordings", "--socket": tmp_path / "d.sock"}
    words = [
        "service",
        "daemon",
        ROBOT_FILE,
        "--simulate",
        *(word for one in options.items() for word in one),
    ]
    with (tmp_path / "log").open("wb") as log:
        process = subprocess.Popen(
            [sys.executable, "-c", NO_EXECUTABLE_MEMORY, *map(str, words)],
            cwd=tmp_path,
            env=environment,
            stderr=log,
        )
    try:
        wait_until(lambda: "READY=1" in manager.heard or process.poll() is not None, START_S)
        assert process.poll() is None, (tmp_path / "log").read_text()
        yield Process(process, manager, tmp_path)
    finally:
        process.kill()
        process.wait()
        manager.close()


def _ready(client: Client) -> None:
    client.power_on()
    client.home()


def test_a_heart_through_the_daemon(daemon: Process, wait_until: WaitUntil) -> None:
    """From power on to a whole recording, with the watchdog fed all the time, ended by SIGTERM."""
    with Client(daemon.socket) as client, Client(daemon.socket) as second:
        _ready(client)
        number = client.submit(daemon.job(0.04, 1))
        stream = second.watch(20.0)
        wait_until(lambda: next(stream).state == "running")
        with pytest.raises(NotReady, match="cannot home: the robot is running"):
            second.home()
        with pytest.raises(ServiceError, match="another daemon answers"):
            _start_a_second_one(daemon)
        wait_until(lambda: next(stream).state == "ready")
        stream.close()
        wait_until(lambda: client.result(number) is not None)  # its recording is closed apart
        result = client.result(number)
        assert (result.outcome, result.recording_error) == ("done", "")
        commanded = client.status().counts
    daemon.process.send_signal(signal.SIGTERM)
    assert daemon.process.wait(30.0) == 0
    run = read_run(Path(result.recording))
    assert run.complete
    assert tuple(run.edges.counts[-1]) == commanded == tuple(run.targets.steps[-1])
    assert min(readings.good.sum() for readings in run.readings.values()) > 20
    wait_until(lambda: "STOPPING=1" in daemon.manager.heard)
    assert daemon.manager.heard.count("WATCHDOG=1") >= 3
    assert not daemon.socket.exists()


def test_killed_in_the_middle(daemon: Process, wait_until: WaitUntil) -> None:
    bench = daemon.bench()
    recording = _in_the_middle_of_a_heart(daemon, wait_until)
    pulse_process = daemon.pulse_process()
    killed_ns = time.monotonic_ns()
    daemon.process.kill()
    wait_until(lambda: _has_ended(pulse_process))
    times_ns = np.array(bench.step_times())
    assert times_ns[-1] > killed_ns - 50_000_000, "the robot was not moving"
    assert times_ns[-1] - killed_ns < HEARTBEAT_S * 1e9
    run = _readable_up_to(recording, killed_ns, bench)
    path_ns = next(event.t_ns for event in run.events if event.kind == "path_start")
    on_path_ns = run.edges.t_ns[run.edges.t_ns > path_ns + 20_000_000]
    assert len(on_path_ns) > 50
    assert np.diff(on_path_ns).min() >= MINIMUM_GAP * T_PWM_NS


def test_hanging_in_the_middle(daemon: Process, wait_until: WaitUntil) -> None:
    """A daemon that neither moves nor dies: no heartbeat, so the pulses end by themselves."""
    bench = daemon.bench()
    recording = _in_the_middle_of_a_heart(daemon, wait_until)
    stopped_ns = time.monotonic_ns()
    daemon.process.send_signal(signal.SIGSTOP)
    time.sleep(HEARTBEAT_S + 0.2)
    last_ns = bench.step_times()[-1]
    assert last_ns > stopped_ns
    assert last_ns - stopped_ns < (HEARTBEAT_S + 0.02) * 1e9
    heard = len(daemon.manager.heard)
    time.sleep(0.1)
    assert len(daemon.manager.heard) == heard  # and nothing feeds the watchdog
    assert bench.step_times()[-1] == last_ns
    daemon.process.kill()
    _readable_up_to(recording, stopped_ns, bench)


def test_stopped_in_the_middle(daemon: Process, wait_until: WaitUntil) -> None:
    """By another client, at once; and after acknowledging and homing by SIGTERM, smoothly."""
    bench = daemon.bench()
    stopped = _in_the_middle_of_a_heart(daemon, wait_until)
    with Client(daemon.socket) as second:
        asked_ns = time.monotonic_ns()
        second.stop("a hand in the way")
        assert second.status().state == "stopped"
        # Measured 4 to 17 ms here; a machine busy with other things may take its time, but no
        # longer than without any daemon at all.
        assert bench.step_times()[-1] - asked_ns < HEARTBEAT_S * 1e9
        with pytest.raises(NotReady, match=r"robot is stopped \(a hand in the way\)"):
            second.submit(daemon.job(0.04, 1))
        second.acknowledge()
        assert second.status().state == "unhomed"
        second.power_off()  # the simulated arms are put back against their stops
    assert any("a hand in the way" in event.text for event in read_run(stopped).events)
    before = np.array(bench.counts())
    ended = _in_the_middle_of_a_heart(daemon, wait_until)
    daemon.process.send_signal(signal.SIGTERM)
    assert daemon.process.wait(30.0) == 0
    run = read_run(ended)
    assert run.complete
    assert tuple(before + run.edges.steps.sum(axis=0)) == bench.counts()
    assert "cancel" in {event.kind for event in run.events}
    assert "run" in {event.text.split()[0] for event in run.events if event.kind == "request"}


def _has_ended(process: int) -> bool:
    """Whether it is gone, or waits only for init to take note of its end."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return True
    return state == "Z"


def _in_the_middle_of_a_heart(daemon: Process, wait_until: WaitUntil) -> Path:
    """Start a long job; returns its recording while the arms move along the path."""
    with Client(daemon.socket) as client:
        _ready(client)
        client.submit(daemon.job(0.1, 20), detach=True)
        wait_until(lambda: client.status().state == "running")
        time.sleep(2.0)  # the last second of a recording may be lost; its path began before that
        status = client.status()
        assert status.state == "running"
        assert status.recording is not None
        return Path(status.recording)


def _readable_up_to(recording: Path, end_ns: int, bench: BenchMemory) -> Run:
    """The recording was cut off, lacks no more than its last second, and tells the truth."""
    run = read_run(recording)
    assert not run.complete
    sent_ns = run.edges.t_ns[np.any(run.edges.steps, axis=1)]
    stepped_ns = np.array(bench.step_times())[: len(sent_ns)]
    assert end_ns - stepped_ns[-1] < 1_000_000_000
    # A write that the machine holds up in its middle has its edge before, its note after.
    apart_ns = stepped_ns - sent_ns
    off_ns = np.sort(np.abs(apart_ns - np.median(apart_ns)))
    assert off_ns[-5] < 1_000_000
    assert off_ns[-1] < HEARTBEAT_S * 1e9
    return run


def _start_a_second_one(daemon: Process) -> None:
    from deltactl.firmware_py.daemon.main import serve

    serve(ROBOT_FILE, daemon.socket, True, daemon.folder / "other")
