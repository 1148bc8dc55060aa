"""Faults of the daemon's own process: killed, or stopped and woken, in the middle of a run."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from mmap import mmap
from pathlib import Path
from random import Random

import numpy as np

from deltactl.drivers.fakes.lines import BENCH_BYTES, BenchMemory
from deltactl.firmware_py.controller.states import State, said
from deltactl.firmware_py.daemon.client import Client, daemon_answers
from deltactl.firmware_py.named_files import TRAINED_FOLDER
from deltactl.foundation.errors import DeltactlError
from deltactl.recording.reading.reader import read_run
from tests.rigs.faults.edges import after, edge_times_ns
from tests.rigs.faults.run_delay import all_waits_s, waited_s
from tests.rigs.faults.stand import JOB, NETWORK, ROBOT_FILE, T_PWM_NS, wait_for
from tests.rigs.faults.verdict import HEARTBEAT_S, Verdict, judge_gaps

START_S = 60.0
"""TimeoutStartSec of the unit."""
LOST_S = 1.0
ON_PATH_S = 1.2
"""From the start of the run until the arms are surely on the path."""
ASLEEP_S = 0.6
PROGRAM = Path(__file__).resolve().parents[2]


class DaemonStand:
    """A daemon as systemd starts it, on the simulated robot in real time."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.job = folder / "heart.yaml"
        self.job.write_text(JOB.replace(NETWORK, str(TRAINED_FOLDER / "zhao-2023.tflite")))
        self.socket = folder / "d.sock"
        self.process = self._start()

    def restart(self) -> None:
        """Start it again, as systemd would."""
        self.close()
        self.process = self._start()

    def close(self) -> None:
        """End it, by force."""
        self.process.kill()
        self.process.wait()

    def begin(self) -> Path:
        """Home, and run a job; returns the recording while the arms are on the path."""
        with Client(self.socket) as client:
            if (state := client.status().state) != "off":
                client.power_off()
            if state in ("stopped", "fault"):
                client.acknowledge()
            else:
                client.power_on()
            client.home()
            client.submit(self.job, detach=True)
            wait_for(lambda: client.status().state == "running", 10.0)
            time.sleep(ON_PATH_S)
            recording = client.status().recording
        assert recording is not None, "the job does not run"
        return Path(recording)

    def bench(self) -> BenchMemory:
        """Where the simulated drives note every step; outlives the process."""
        return bench_of(self.process.pid)

    def pulse_pid(self) -> int:
        """Number of the pulse process."""
        return pulse_process_of(self._children())

    def waited_s(self) -> dict[str, float]:
        """How long each thread, of the pulse process too, has waited for a core so far."""
        return waited_s(self.process.pid, *self._children())

    def _children(self) -> list[int]:
        listed = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        with suppress(OSError):
            return [int(word) for word in listed.read_text().split()]
        return []

    def _start(self) -> subprocess.Popen[bytes]:
        places = ["--socket", str(self.socket), "--recordings", str(self.folder / "recordings")]
        program = "from deltactl.cli.main import main; main()"
        with (self.folder / "log").open("ab") as log:
            process = subprocess.Popen(
                [
                    sys.executable,
                    "-c",
                    program,
                    "service",
                    "daemon",
                    str(ROBOT_FILE),
                    "--simulate",
                    *places,
                ],
                cwd=self.folder,
                env=os.environ | {"PYTHONPATH": str(PROGRAM)},
                stderr=log,
            )
        if wait_for(self._answers, START_S) is None:
            process.kill()
            process.wait()
            said = (self.folder / "log").read_text()[-2000:]
            raise TimeoutError(f"the daemon does not answer within {START_S:g} s: {said}")
        return process

    def _answers(self) -> bool:
        with suppress(DeltactlError):
            return daemon_answers(self.socket)
        return False


def pulse_process_of(processes: list[int]) -> int:
    """Which of a daemon's children plays the pulses; another plans."""
    named = {one: Path(f"/proc/{one}/cmdline").read_bytes() for one in processes}
    (found,) = [one for one, words in named.items() if b"pulse_main" in words]
    return found


def bench_of(pid: int) -> BenchMemory:
    """Memory of the simulated drives of a daemon that runs."""
    folder = Path(f"/proc/{pid}/fd")
    found = next(one for one in folder.iterdir() if "deltactl-bench" in os.readlink(one))
    descriptor = os.open(found, os.O_RDWR)
    try:
        return BenchMemory(mmap(descriptor, BENCH_BYTES))
    finally:
        os.close(descriptor)


def kill_daemon(stand: DaemonStand, chance: Random) -> Verdict:
    """kill -9 of the daemon: the pulses end, the recording stays, nothing moves after a start."""
    verdict = Verdict("daemon kill -9")
    recording, bench, pulses = stand.begin(), stand.bench(), stand.pulse_pid()
    before_s = stand.waited_s()
    time.sleep(chance.uniform(0.0, 0.5))
    verdict.waited_s = all_waits_s(before_s, stand.waited_s())
    fault_ns = time.monotonic_ns()
    stand.process.kill()
    ended = wait_for(lambda: _is_gone(pulses), 2.0)
    verdict.seen_s = (time.monotonic_ns() - fault_ns) * 1e-9
    verdict.demand(ended is not None, "the pulse process lives on")
    _judge(verdict, bench, recording, fault_ns, HEARTBEAT_S)
    stand.restart()
    with Client(stand.socket) as client:
        status = client.status()
        verdict.demand(status.state == "off", f"started again, and {status.state}")
        verdict.demand(status.position_m is None, "the old position is trusted")
        _must_refuse(client, stand, verdict, "off")
    return verdict


def stop_daemon(stand: DaemonStand, chance: Random) -> Verdict:
    """SIGSTOP of the daemon: the pulses end; woken, it says why and does not just go on."""
    verdict = Verdict("daemon SIGSTOP")
    recording, bench, before_s = stand.begin(), stand.bench(), stand.waited_s()
    time.sleep(chance.uniform(0.0, 0.5))
    fault_ns = time.monotonic_ns()
    stand.process.send_signal(signal.SIGSTOP)
    time.sleep(ASLEEP_S)
    last_ns = int(edge_times_ns(bench)[-1])
    stand.process.send_signal(signal.SIGCONT)
    woken_ns = time.monotonic_ns()
    with Client(stand.socket) as client:
        wait_for(lambda: client.status().state == "fault", 1.0)
        verdict.seen_s = (time.monotonic_ns() - woken_ns) * 1e-9
        status = client.status()
        verdict.demand("no heartbeat" in status.why, f"culprit not named: {status.why!r}")
        _must_refuse(client, stand, verdict, "fault")
        client.acknowledge()
        _must_refuse(client, stand, verdict, "unhomed")
    verdict.demand(int(edge_times_ns(bench)[-1]) == last_ns, "moved when it was woken")
    _judge(verdict, bench, recording, fault_ns, HEARTBEAT_S)
    verdict.waited_s = all_waits_s(before_s, stand.waited_s())
    return verdict


def kill_pulses_of_daemon(stand: DaemonStand, chance: Random) -> Verdict:
    """kill -9 of the pulse process: the daemon releases the drives, ends, is started again."""
    verdict = Verdict("daemon without pulse process")
    recording, bench, pulses = stand.begin(), stand.bench(), stand.pulse_pid()
    before_s = stand.waited_s()
    time.sleep(chance.uniform(0.0, 0.5))
    verdict.waited_s = all_waits_s(before_s, stand.waited_s())
    fault_ns = time.monotonic_ns()
    os.kill(pulses, signal.SIGKILL)
    released = wait_for(lambda: not bench.energised, 1.0)
    verdict.seen_s = (time.monotonic_ns() - fault_ns) * 1e-9
    verdict.demand(released is not None, "the drives are still energised")
    ended = wait_for(lambda: stand.process.poll() is not None, 4.0)
    verdict.demand(ended is not None, "the daemon lives on without pulse process")
    verdict.demand(stand.process.poll() == 1, f"it ended with status {stand.process.poll()}")
    _judge(verdict, bench, recording, fault_ns, HEARTBEAT_S)
    said = (stand.folder / "log").read_text()
    verdict.demand("pulse process ended (signal 9)" in said, "the log does not name the culprit")
    stand.restart()
    with Client(stand.socket) as client:
        verdict.demand(client.status().state == "off", f"then {client.status().state}")
        _must_refuse(client, stand, verdict, "off")
    return verdict


DaemonFault = Callable[[DaemonStand, Random], Verdict]
DAEMON_KINDS: dict[str, DaemonFault] = {
    "daemon kill -9": kill_daemon,
    "daemon SIGSTOP": stop_daemon,
    "daemon without pulse process": kill_pulses_of_daemon,
}


def _judge(
    verdict: Verdict, bench: BenchMemory, recording: Path, fault_ns: int, within_s: float
) -> None:
    times_ns = edge_times_ns(bench)
    verdict.last_edge_s = max(0.0, (int(times_ns[-1]) - fault_ns) * 1e-9)
    late = f"last edge {verdict.last_edge_s * 1e3:.1f} ms after"
    verdict.demand(verdict.last_edge_s <= within_s, late)
    verdict.demand(times_ns[-1] > fault_ns - 50_000_000, "the robot was not moving")
    judge_gaps(verdict, after(times_ns, fault_ns - 200_000_000), T_PWM_NS)
    verdict.demand(bench.lost() == (0, 0, 0), f"the drives lost {bench.lost()}")
    try:
        run = read_run(recording)
    except DeltactlError as error:
        verdict.demand(False, f"recording unreadable: {error}")
        return
    sent = int(np.any(run.edges.steps, axis=1).sum())
    run_ns = times_ns[-_edges_of_run(times_ns) :]
    verdict.miscounted = max(0, sent - len(run_ns))
    verdict.demand(verdict.miscounted == 0, f"{sent} edges recorded, {len(run_ns)} sent")
    if sent:
        verdict.unrecorded_s = float(run_ns[-1] - run_ns[min(sent, len(run_ns)) - 1]) * 1e-9
    verdict.demand(sent > 0, "no edge recorded")
    verdict.demand(verdict.unrecorded_s <= LOST_S, f"{verdict.unrecorded_s:.2f} s not recorded")


def _edges_of_run(times_ns: np.ndarray[tuple[int], np.dtype[np.int64]]) -> int:
    """How many edges belong to the last run: those after the last long pause."""
    pauses = np.flatnonzero(np.diff(times_ns) > 300_000_000)
    return len(times_ns) - (int(pauses[-1]) + 1 if len(pauses) else 0)


def _must_refuse(client: Client, stand: DaemonStand, verdict: Verdict, state: str) -> None:
    try:
        client.submit(stand.job)
        verdict.demand(False, f"took a job while {state}")
    except DeltactlError as error:
        named = f"the robot is {said(State(state))}" in str(error)
        verdict.demand(named, f"refused for another reason: {error}")


def _is_gone(process: int) -> bool:
    """Whether it has ended, or waits only for init to take note of its end."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return True
    return state == "Z"
