"""Commands as processes of their own, forked from one that has the program imported.

A process that is started anew imports for a second before it does anything. Here one does so, once
for all tests of a worker, and forks whenever a test starts a command: what is forked has its own
memory, signals, exit status and end, as any command that somebody types.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import selectors
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import IO, Any

PROGRAM = Path(__file__).resolve().parents[2]
MOST_BYTES = 1 << 20
"""Of a request: its words and its environment."""


class Started:
    """A command that runs; as much of `subprocess.Popen` as tests use."""

    def __init__(self, pid: int, report: socket.socket, out: IO[str], err: IO[str]):
        self.pid, self._report = pid, report
        self.stdout, self.stderr = out, err
        self._said = {out: b"", err: b""}
        self.returncode: int | None = None

    def poll(self) -> int | None:
        """Exit status, negative for a signal; None while it runs."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.wait(0.0)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended. Raises subprocess.TimeoutExpired."""
        if self.returncode is None:
            self._report.settimeout(timeout)
            try:
                self.returncode = int(self._report.recv(16))
            except (TimeoutError, BlockingIOError):
                raise subprocess.TimeoutExpired("deltactl", timeout or 0.0) from None
            self._report.close()
        return self.returncode

    def communicate(self, timeout: float | None = None) -> tuple[str, str]:
        """All that it still prints, once it has ended. Raises subprocess.TimeoutExpired."""
        until_s = None if timeout is None else time.monotonic() + timeout
        with selectors.DefaultSelector() as ready:
            for stream in self._said:
                ready.register(stream, selectors.EVENT_READ, stream)
            while ready.get_map():
                left_s = None if until_s is None else until_s - time.monotonic()
                if left_s is not None and left_s <= 0.0:
                    raise subprocess.TimeoutExpired("deltactl", timeout or 0.0)
                for key, _ in ready.select(left_s):
                    part = os.read(key.fd, 65536)
                    self._said[key.data] += part
                    if not part:
                        ready.unregister(key.fileobj)
        self.wait(None if until_s is None else max(until_s - time.monotonic(), 0.0))
        self._let_go()
        out, err = (self._said[one].decode() for one in (self.stdout, self.stderr))
        return out, err

    def send_signal(self, number: int) -> None:
        """Nothing where it has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """SIGKILL."""
        self.send_signal(signal.SIGKILL)

    def close(self) -> None:
        """Kill it where it runs, and let go of its output."""
        self.kill()
        self.wait()
        self._let_go()

    def _let_go(self) -> None:
        self.stdout.close()
        self.stderr.close()

    def __enter__(self) -> Started:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()


def started(
    *words: object, cwd: Path | None = None, env: Mapping[str, str] | None = None
) -> Started:
    """Start `deltactl WORDS`, with the signals of a terminal: no test runs it under nohup."""
    asked = {
        "words": [str(word) for word in words],
        "cwd": str(cwd or Path.cwd()),
        "env": dict(os.environ if env is None else env),
    }
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
    (out, out_end), (err, err_end) = os.pipe(), os.pipe()
    ends = [out_end, err_end, theirs.fileno()]
    socket.send_fds(_forks(), [json.dumps(asked).encode()], ends)
    theirs.close()
    for end in (out_end, err_end):
        os.close(end)
    pid = int(ours.recv(16))
    return Started(pid, ours, os.fdopen(out), os.fdopen(err))


@cache
def _forks() -> socket.socket:
    """The process that has the program imported: a socket to it; it ends with this one."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    for end in (ours, theirs):
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, MOST_BYTES)
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.rigs.started", str(theirs.fileno())],
        cwd=PROGRAM, pass_fds=[theirs.fileno()],
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    theirs.close()
    atexit.register(process.wait)
    atexit.register(ours.close)  # called first: without it the other side would wait
    return ours


# ---- in the process that forks -----------------------------------------------------------------


def _serve(asks: socket.socket) -> dict[str, Any] | None:
    """Fork for each request; returns what was asked for in the fork, None once nobody asks."""
    running: dict[int, tuple[int, socket.socket]] = {}
    with selectors.DefaultSelector() as ready:
        ready.register(asks, selectors.EVENT_READ)
        while True:
            for key, _ in ready.select():
                if key.fd != asks.fileno():
                    pid, report = running.pop(key.fd)
                    ready.unregister(key.fd)
                    os.close(key.fd)
                    status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
                    with contextlib.suppress(BrokenPipeError), report:
                        report.sendall(str(status).encode())
                    continue
                text, ends, _, _ = socket.recv_fds(asks, MOST_BYTES, 3)
                if not text:
                    return None
                out, err, report_end = ends
                if not (pid := os.fork()):
                    for one in (report_end, *running):
                        os.close(one)
                    for other in (asks, *(report for _, report in running.values())):
                        other.close()
                    _become(out, err)
                    asked: dict[str, Any] = json.loads(text)
                    return asked
                os.close(out)
                os.close(err)
                report = socket.socket(fileno=report_end)
                report.sendall(str(pid).encode())
                watched = os.pidfd_open(pid)
                running[watched] = pid, report
                ready.register(watched, selectors.EVENT_READ)


def _become(out: int, err: int) -> None:
    """Have the output and the signals of a command."""
    for end, number in ((out, 1), (err, 2)):
        os.dup2(end, number)
        os.close(end)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def _imported() -> None:
    """Modules that commands import when they are called."""
    import deltactl.cli.main
    import deltactl.cli.robot.check
    import deltactl.cli.robot.run
    import deltactl.diagnosis.api  # noqa: F401


def _main() -> None:
    asks = socket.socket(fileno=int(sys.argv[1]))
    _imported()
    asked = _serve(asks)
    if asked is None:
        return
    os.chdir(asked["cwd"])
    os.environ.clear()
    os.environ.update(asked["env"])
    sys.argv = ["deltactl", *asked["words"]]
    from deltactl.cli.main import main

    main()


if __name__ == "__main__":
    _main()
