"""Soak: python benchmarks/endurance/soak.py [--hours 24] or [--real-minutes 20].

--hours: simulated running on the virtual clock, job after job through the daemon's table of
requests, with homing, pauses, cancelled jobs, breaks and `verify`; the step watch looks on.
--real-minutes: a daemon of its own in real time, with its pulse process, over its socket.
Prints worst figures and slopes of memory, open files, threads, counters and recordings.
"""

from __future__ import annotations

import argparse
import itertools
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.endurance.soak_virtual import Sample, Tally, soak_virtual
from deltactl.drivers.fakes.lines import BenchMemory
from deltactl.firmware_py.controller.contract import JobResult
from deltactl.firmware_py.daemon.client import Client, daemon_answers
from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.foundation.errors import DeltactlError
from deltactl.recording.reading.reader import read_run
from tests.rigs.faults.daemon_stand import bench_of
from tests.rigs.faults.stand import wait_for
from tests.rigs.faults.vitals import vitals

PROGRAM = Path(__file__).resolve().parents[2]
KEPT = "\nrecordings: {max_gib: 0.01, max_age_days: 0.005, keep_free_gib: 0.5}\n"
MOST_MB, MOST_AGE_S, MARGIN_S = 0.01 * 1024, 0.005 * 86_400.0, 65.0
"""The daemon looks once a minute; until then a megabyte more may lie there."""
SAMPLE_S = 5.0
RECOVERIES = 20
MB = 2**20
JOBS = (("heart", 1), ("circle", 3), ("spiral", 1))


class RealSoak:
    """The daemon, who asks of it, and who looks on."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.recordings = folder / "recordings"
        self.tally = Tally()
        self._robot = folder / "robot.yaml"
        self._robot.write_text((CONFIG_FOLDER / "zhao-2023.yaml").read_text() + KEPT)
        self._socket = folder / "d.sock"
        self._jobs = [self._job(name, repeats) for name, repeats in JOBS]
        self.process = self._start()
        self._ending = threading.Event()
        self._looking = threading.Thread(target=self._look, daemon=True)
        self._offset = (0, 0, 0)

    def run(self, minutes: float) -> None:
        """Jobs, pauses, homing and clients until the time is over; then SIGTERM."""
        end_s = time.monotonic() + minutes * 60.0
        bench = bench_of(self.process.pid)
        self._looking.start()
        with Client(self._socket) as client:
            client.power_on()
            for number, job in zip(itertools.count(), itertools.cycle(self._jobs), strict=False):
                if time.monotonic() > end_s:
                    break
                try:
                    if number % 3 == 0:
                        self._home(client, bench)
                    self._run_job(client, bench, job, end_s)
                except DeltactlError as error:
                    self.tally.problems.append(str(error))
                    self._recover(client, bench)
            with suppress(DeltactlError):
                client.cancel()
        self._ending.set()
        self._looking.join(5.0)
        self.process.terminate()
        self.tally.count(f"exit status {self.process.wait(15.0)}")

    def _home(self, client: Client, bench: BenchMemory) -> None:
        client.home()
        counts, there = client.status().counts, bench.counts()
        self._offset = (counts[0] - there[0], counts[1] - there[1], counts[2] - there[2])
        self.tally.count("homed")

    def _run_job(self, client: Client, bench: BenchMemory, job: Path, end_s: float) -> None:
        number, sampled_s = client.submit(job), 0.0
        paused_s = time.monotonic() + 15.0
        while (result := client.result(number)) is None and time.monotonic() < end_s:
            time.sleep(0.25)
            if time.monotonic() > sampled_s + SAMPLE_S:
                sampled_s = time.monotonic()
                self._sample(client, bench)
            if time.monotonic() > paused_s:
                paused_s += 1e9
                self._pause(client)
        if result is not None:
            self._ended(result, client, bench)

    def _recover(self, client: Client, bench: BenchMemory) -> None:
        """What an operator does, until it works; the simulated arms drop to their stops."""
        for _ in range(RECOVERIES):
            self.tally.count("recovered from a fault")
            with suppress(DeltactlError):
                if client.status().state == "fault":
                    client.acknowledge()
                client.power_off()
                client.power_on()
                self._home(client, bench)
                return
        raise TimeoutError(f"cannot be homed any more: {client.status()}")

    def _pause(self, client: Client) -> None:
        with suppress(DeltactlError):  # the job may have ended just now
            client.pause()
            time.sleep(2.0)
            client.resume()
            self.tally.count("paused")

    def _ended(self, result: JobResult, client: Client, bench: BenchMemory) -> None:
        self.tally.count(f"jobs {result.outcome}")
        if result.outcome != "done" or result.recording_error or result.warning:
            self.tally.problems.append(str(result))
        if result.outcome == "fault":
            return
        counts = client.status().counts
        drift = self._drift(counts, bench)
        if drift:
            self.tally.problems.append(f"counter and drive {drift} steps apart after {result.name}")
        run = read_run(Path(result.recording or ""))
        if not run.complete or tuple(run.edges.counts[-1]) != counts:
            self.tally.problems.append(f"{result.recording}: ends at {run.edges.counts[-1]}")
        self.tally.count("edges recorded", int(np.abs(run.edges.steps).sum()))

    def _drift(self, counts: tuple[int, int, int], bench: BenchMemory) -> int:
        three = zip(counts, bench.counts(), self._offset, strict=True)
        return max(abs(count - there - offset) for count, there, offset in three)

    def _sample(self, client: Client, bench: BenchMemory) -> None:
        # Arms move between the looks at the one and the other: the smallest of several counts.
        drift = min(self._drift(client.status().counts, bench) for _ in range(5))
        found = [path.stat() for path in self.recordings.glob("*.mcap")]
        oldest_s = time.time() - min((file.st_mtime for file in found), default=time.time())
        size_mb = sum(file.st_size for file in found) / MB
        self.tally.samples.append(
            Sample(
                (time.monotonic() - self._began_s) / 3600.0,
                vitals(self.process.pid),
                drift,
                sum(bench.lost()),
                len(found),
                size_mb,
                oldest_s,
                shutil.disk_usage(self.recordings).free / MB,
            )
        )
        if len(found) > 2 and (oldest_s > MOST_AGE_S + MARGIN_S or size_mb > MOST_MB + 2.0):
            self.tally.problems.append(f"{size_mb:.1f} MB, the oldest {oldest_s:.0f} s old")

    def _look(self) -> None:
        """Others look on: one for long, one again and again."""
        while not self._ending.is_set():
            with suppress(DeltactlError), Client(self._socket) as client:
                stream = client.watch(5.0)
                for _ in range(50):
                    next(stream)
                    self._ending.wait(0.05)
                stream.close()
                daemon_answers(self._socket)
                self.tally.count("other clients", 3)

    def _job(self, name: str, repeats: int) -> Path:
        lines = (CONFIG_FOLDER / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
        kept = [line for line in lines if not line.startswith(("repeats:", "robot:"))]
        path = self.folder / f"{name}.yaml"
        path.write_text("\n".join([*kept, "robot: robot.yaml", f"repeats: {repeats}", ""]))
        return path

    def _start(self) -> subprocess.Popen[bytes]:
        places = ["--socket", str(self._socket), "--recordings", str(self.recordings)]
        program = "from deltactl.cli.main import main; main()"
        with (self.folder / "log").open("ab") as log:
            process = subprocess.Popen(
                [
                    sys.executable,
                    "-c",
                    program,
                    "service",
                    "daemon",
                    str(self._robot),
                    "--simulate",
                    *places,
                ],
                cwd=self.folder,
                env=os.environ | {"PYTHONPATH": str(PROGRAM)},
                stderr=log,
            )
        self._began_s = time.monotonic()
        if wait_for(self._answers, 30.0) is None:
            process.kill()
            raise TimeoutError((self.folder / "log").read_text()[-2000:])
        return process

    def _answers(self) -> bool:
        with suppress(DeltactlError):
            return daemon_answers(self._socket)
        return False


def soak_real(minutes: float, folder: Path) -> int:
    """Run, print the table; 1 when something is not as it should be."""
    folder.mkdir(parents=True, exist_ok=True)
    soak = RealSoak(folder)
    start_s = time.monotonic()
    try:
        soak.run(minutes)
    finally:
        soak.process.kill()
    log = (folder / "log").read_text(encoding="utf-8", errors="replace")
    soak.tally.count("recordings deleted", log.count("deleted to make room"))
    soak.tally.count("lines of trouble in the log", log.count("Traceback") + log.count("ERROR"))
    print(f"{(time.monotonic() - start_s) / 60.0:.1f} minutes of a daemon in real time")
    print("\n".join(soak.tally.rows()))
    return int(bool(soak.tally.problems))


def main() -> int:
    """Exit status 1 when something grew, drifted, was lost or was reported falsely."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=24.0, help="of virtual running")
    parser.add_argument("--real-minutes", type=float, help="run a daemon in real time instead")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, help="for recordings; a small disk is a good one")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="deltactl-soak-") as scratch:
        folder = options.folder or Path(scratch)
        if options.real_minutes:
            return soak_real(options.real_minutes, folder)
        return soak_virtual(options.hours, folder, options.seed)


if __name__ == "__main__":
    sys.exit(main())
