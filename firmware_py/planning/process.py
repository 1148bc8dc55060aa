"""The daemon's side of planning: one waiting process for each job, started before it is needed."""

from __future__ import annotations

import contextlib
import json
import mmap
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

from deltactl.firmware_py.file_access import FileAccess
from deltactl.firmware_py.planning.packed import unpack
from deltactl.firmware_py.planning.prepared import CalledOff, InForce, Prepared
from deltactl.firmware_py.wire_errors import as_exception
from deltactl.foundation.errors import ConfigError, ServiceError
from deltactl.foundation.places import importable

MOST_BYTES = 4 * 2**20
"""A survey of 100 000 poses written out is about 3 MB."""
MOST_S = 300.0
"""Mapping a million targets takes a Pi a minute or two."""


NOTHING_SHOWN = FileAccess(follow=False, quote=False)
"""For the network that is opened here, once more."""


class PlanningProcess:
    """Prepares jobs, one at a time; any thread may call, `close` too."""

    def __init__(
        self,
        most_s: float = MOST_S,
        most_bytes: int = MOST_BYTES,
        sent: Path | None = None,
    ):
        """`sent`: the folder of jobs that clients sent as text, which refusals may quote."""
        self._sent = None if sent is None else sent.absolute()
        self._most_s, self._most_bytes = most_s, most_bytes
        self._turn = threading.Lock()
        self._next: _Worker | None = _Worker()
        self._closed = False

    def prepare(self, job_file: Path, robot: InForce, asked: CalledOff | None = None) -> Prepared:
        """As `prepare_here`, and bounded: ConfigError when it is too long or takes too long.

        Called off, its process is ended, and ServiceError raised at once.
        """
        with self._turn:
            if self._closed:
                raise ServiceError("the planner is closed; start the daemon again")
            worker, self._next = self._next or _Worker(), None
            try:
                if asked is not None:
                    asked.when_called_off(worker.end)
                answer = worker.ask(self._question(job_file, robot), self._most_s)
                return self._understood(answer, worker, job_file, robot)
            except subprocess.TimeoutExpired:
                raise self._too_long(job_file) from None
            finally:
                worker.close()
                self._next = _Worker()

    def close(self) -> None:
        """End the process that waits, or works."""
        self._closed = True
        worker = self._next
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
        return unpack(worker.block(int(answer["bytes"])), robot, job_file, NOTHING_SHOWN)

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

    def ask(self, question: dict[str, Any], limit_s: float) -> dict[str, Any] | None:
        """Its answer, or None when it ended without. Raises TimeoutExpired."""
        said, _ = self._process.communicate(json.dumps(question).encode() + b"\n", limit_s)
        try:
            answer = json.loads(said)
        except ValueError:
            return None
        return answer if isinstance(answer, dict) else None

    @property
    def out_of_time(self) -> bool:
        """Whether the kernel ended it for the time it used (SIGXCPU, then SIGKILL)."""
        return self._process.returncode in (-24, -9)

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
