"""The daemon's side of planning: a process that waits for each job, started before it is needed.

It plans one job, and ends; what it refuses, and robot files, leave it waiting for the next.
"""

from __future__ import annotations

import contextlib
import json
import mmap
import os
import select
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.planning.packed import unpack
from deltactl.firmware_py.planning.prepared import CalledOff, InForce, Prepared, RobotRead
from deltactl.firmware_py.wire_errors import as_exception
from deltactl.foundation.errors import ConfigError, ServiceError
from deltactl.foundation.process import importable

MOST_BYTES = 4 * 2**20
"""A survey of 100 000 poses written out is about 3 MB."""
MOST_S = 300.0
"""Mapping a million targets takes a Pi a minute or two."""


MOST_READ_S = 1.5
"""Processor time: a robot file is read and checked in a few hundredths of a second."""
PART_BYTES = 65_536
START_S = 20.0
"""A process starts within that, on a Pi that does much else."""


class PlanningProcess:
    """Prepares jobs, one at a time; any thread may call, `close` too."""

    def __init__(
        self,
        most_s: float = MOST_S,
        most_bytes: int = MOST_BYTES,
        sent: Path | None = None,
        most_read_s: float = MOST_READ_S,
    ):
        """`sent`: the folder of jobs that clients sent as text, which refusals may quote."""
        self._sent = None if sent is None else sent.absolute()
        self._most_s, self._most_bytes, self._most_read_s = most_s, most_bytes, most_read_s
        self._turn = threading.Lock()
        self._spare = threading.Lock()
        self._next: _Worker | None = _Worker()
        self._closed = False

    def prepare(self, job_file: Path, robot: InForce, asked: CalledOff | None = None) -> Prepared:
        """As `prepare_here`, and bounded: ConfigError when it is too long or takes too long.

        Called off, its process is ended, and ServiceError raised at once.
        """
        with self._turn:
            if self._closed:
                raise ServiceError("the planner is closed; start the daemon again")
            worker, over = self._take(), threading.Event()
            try:
                if asked is not None:
                    asked.when_called_off(lambda: None if over.is_set() else worker.end())
                answer = worker.ask(self._question(job_file, robot), self._most_s)
                return self._understood(answer, worker, job_file, robot)
            except subprocess.TimeoutExpired:
                raise self._too_long(job_file) from None
            finally:
                over.set()  # who waits for the next question is ended for none before
                self._give_back(worker)

    def read_robot(self, path: Path, access: FileAccess) -> RobotRead:
        """As `read_robot_here`, and bounded; waits for no job that is being planned.

        Raises ConfigError when it takes too long.
        """
        if self._closed:
            raise ServiceError("the planner is closed; start the daemon again")
        worker, in_all_s = self._take(), self._most_read_s + START_S
        question = {
            "robot": str(path),
            "follow": access.follow,
            "quote": access.quote,
            "most_bytes": min(access.most_bytes, self._most_bytes),
            "most_s": self._most_read_s,
        }
        try:
            answer = worker.ask(question, in_all_s)
            if answer is None and not worker.out_of_time:
                raise ServiceError(
                    f"{path}: the reader ended ({worker.epitaph}); see the log of the daemon"
                )
            if answer is None:
                raise subprocess.TimeoutExpired("reader", self._most_read_s)
        except subprocess.TimeoutExpired:
            raise ConfigError(
                f"{path}: to read it takes longer than {self._most_read_s:g} s of processor time,"
                f" or {in_all_s:g} s in all; is it a robot file?"
            ) from None
        finally:
            self._give_back(worker)
        if "kind" in answer:
            raise as_exception(answer)
        return RobotRead.of(answer)

    def _take(self) -> _Worker:
        """The process that waits, or one that starts now."""
        with self._spare:
            worker, self._next = self._next, None
        return worker or _Worker()

    def _give_back(self, worker: _Worker) -> None:
        """Have one wait for whoever comes next: the same, unless it has ended."""
        with self._spare:
            if self._next is None and not self._closed:
                self._next = worker if worker.goes_on else _Worker()
                if self._next is worker:
                    return
        worker.close()

    def close(self) -> None:
        """End the process that waits, or works."""
        with self._spare:
            self._closed = True
            worker, self._next = self._next, None
        if worker is not None:
            worker.close()

    def _question(self, job_file: Path, robot: InForce) -> dict[str, Any]:
        return {
            "job": str(job_file),
            "robot_path": str(robot.path),
            "robot_text": robot.text,
            "robot_started": "" if robot.started is None else str(robot.started),
            "most_s": max(1, round(self._most_s)),
            "most_bytes": self._most_bytes,
            "quote": self._sent is None or job_file.parent == self._sent,
        }

    def _understood(
        self, answer: dict[str, Any] | None, worker: _Worker, job_file: Path, robot: InForce
    ) -> Prepared:
        if answer is None:
            raise (
                self._too_long(job_file)
                if worker.out_of_time
                else ServiceError(
                    f"{job_file}: the planner ended ({worker.epitaph}); see the log of the daemon"
                )
            )
        if "kind" in answer:
            raise as_exception(answer)
        nothing_shown = FileAccess(follow=False, quote=False)  # for the network, opened once more
        return unpack(worker.block(int(answer["bytes"])), robot, job_file, nothing_shown)

    def _too_long(self, job_file: Path) -> ConfigError:
        return ConfigError(
            f"{job_file}: planning takes longer than {self._most_s:g} s; split the job"
        )


class _Worker:
    """One process and the memory it may write into."""

    def __init__(self) -> None:
        self._memory = os.memfd_create("deltactl-plan")
        module = ["-P", "-m", "deltactl.firmware_py.planning.worker", str(self._memory)]
        hidden = {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}
        kept = {name: value for name, value in os.environ.items() if name not in hidden}
        self._process = subprocess.Popen(
            [sys.executable, *module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            pass_fds=(self._memory,),
            env=importable(kept),
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._ask, self._say = self._process.stdin.fileno(), self._process.stdout.fileno()
        os.set_blocking(self._ask, False)
        os.set_blocking(self._say, False)
        self.goes_on = False
        """Whether it waits for another question: it ends with a plan, which is in its memory."""

    def ask(self, question: dict[str, Any], limit_s: float) -> dict[str, Any] | None:
        """Its answer, or None when it ended without. Raises TimeoutExpired."""
        self.goes_on = False
        left, said = memoryview(json.dumps(question).encode() + b"\n"), bytearray()
        poll, give_up_s = select.poll(), time.monotonic() + limit_s
        poll.register(self._say, select.POLLIN)
        poll.register(self._ask, select.POLLOUT)
        while not said.endswith(b"\n"):
            ready = dict(poll.poll(max(0.0, give_up_s - time.monotonic()) * 1e3))
            if not ready:
                raise subprocess.TimeoutExpired("planner", limit_s)
            if self._ask in ready:
                left = self._sent(left)
                if not left:
                    poll.unregister(self._ask)
            if self._say in ready:
                part = os.read(self._say, PART_BYTES)
                if not part:
                    self._process.wait()
                    return None
                said += part
        answer = json.loads(said)
        self.goes_on = "bytes" not in answer
        return answer if isinstance(answer, dict) else None

    def _sent(self, left: memoryview) -> memoryview:
        """What is left to send; nothing when nobody reads any more, which the answer tells."""
        try:
            return left[os.write(self._ask, left[:PART_BYTES]) :]
        except BlockingIOError:
            return left
        except BrokenPipeError:
            return left[:0]

    @property
    def out_of_time(self) -> bool:
        """Whether the kernel ended it for the time it used (SIGXCPU, then SIGKILL; SIGPROF)."""
        return self._process.returncode in (-24, -9, -27)

    @property
    def epitaph(self) -> str:
        """How it ended."""
        return f"status {self._process.returncode}"

    def block(self, size: int) -> mmap.mmap:
        """What it wrote, as memory that lives as long as somebody looks at it."""
        return mmap.mmap(self._memory, size, access=mmap.ACCESS_READ)

    def end(self) -> None:
        """End it; whoever waits for its answer gets none."""
        with contextlib.suppress(ProcessLookupError):
            self._process.kill()

    def close(self) -> None:
        """End it; the memory goes when nobody looks at it any more."""
        self.end()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                stream.close()
        if self._memory >= 0:
            os.close(self._memory)
            self._memory = -1
