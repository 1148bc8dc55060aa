"""A daemon without file descriptors: a stop gets through, and the log does not fill the disk."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import resource
import socket
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

MORE_FILES = 40
STOPS_S = 1.0
WATCHED_S = 0.6


@contextlib.contextmanager
def no_files_left() -> Iterator[None]:
    """Every descriptor that this process may have is open."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    highest = max(int(name) for name in os.listdir("/proc/self/fd"))
    resource.setrlimit(resource.RLIMIT_NOFILE, (highest + MORE_FILES, hard))
    held: list[int] = []
    try:
        with contextlib.suppress(OSError):
            while True:
                held.append(os.open(os.devnull, os.O_RDONLY))
        yield
    finally:
        for descriptor in held:
            os.close(descriptor)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def ask(client: socket.socket, path: str, do: str) -> dict[str, Any]:
    client.settimeout(STOPS_S)
    client.connect(path)
    client.sendall(json.dumps({"id": 1, "do": do}).encode() + b"\n")
    answer: dict[str, Any] = json.loads(client.recv(65_536))
    return answer


def test_a_stop_gets_through_and_the_log_has_one_line(
    serve: Callable[..., Any], caplog: pytest.LogCaptureFixture
) -> None:
    daemon = serve()
    stopping, asking, waiting, later = (socket.socket(socket.AF_UNIX) for _ in range(4))
    with stopping, asking, waiting, later, caplog.at_level(logging.INFO):
        with no_files_left():
            begun_s = time.monotonic()
            assert ask(stopping, str(daemon.path), "stop")["ok"] is True
            assert time.monotonic() - begun_s < STOPS_S
            assert daemon.controller.state.value == "stopped"
            assert ask(asking, str(daemon.path), "status")["ok"] is False
            waiting.connect(str(daemon.path))
            time.sleep(WATCHED_S)
        complaints = [one for one in caplog.records if "file descriptor" in one.getMessage()]
        assert len(complaints) == 1
        assert ask(later, str(daemon.path), "status")["ok"] is True
        assert len(caplog.records) < 10


def test_it_is_logged_anew_each_time(
    serve: Callable[..., Any], caplog: pytest.LogCaptureFixture
) -> None:
    daemon = serve()
    clients = [socket.socket(socket.AF_UNIX) for _ in range(4)]
    with contextlib.ExitStack() as kept, caplog.at_level(logging.INFO):
        for client in clients:
            kept.enter_context(client)
        for refused, let_in in (clients[:2], clients[2:]):
            with no_files_left():
                assert ask(refused, str(daemon.path), "status")["ok"] is False
            assert ask(let_in, str(daemon.path), "status")["ok"] is True
    complaints = [one for one in caplog.records if "file descriptor" in one.getMessage()]
    assert len(complaints) == 2
