"""One connection of a client: finds the daemon, sends requests, finds their answers."""

from __future__ import annotations

import contextlib
import json
import socket
import time
from collections.abc import Iterator
from pathlib import Path

from deltactl.firmware_py import wire_errors
from deltactl.firmware_py.daemon import protocol
from deltactl.firmware_py.daemon.address import client_sockets
from deltactl.firmware_py.daemon.protocol import MAX_LINE_BYTES, Message
from deltactl.firmware_py.named_files import proposed
from deltactl.foundation.errors import ServiceError

RETRY_S = 0.002


def start_it() -> str:
    """How a daemon is started, with the robot files that are here."""
    simulated = " or ".join(f"'deltactl service daemon {name} --simulate'" for name in proposed())
    return f"start it with 'sudo systemctl start deltactl', or a simulated one with {simulated}"


class Line:
    """An open connection. Raises ServiceError when nobody answers at `path`, or any more."""

    def __init__(self, path: Path | None, connect_s: float):
        found = find_daemon(path, connect_s)
        if found is None:
            raise ServiceError(f"no daemon answers at {client_sockets(path)[-1]}; {start_it()}")
        self.path, self._socket = found
        self._rest = b""
        self._last_id = 0

    def ask(self, message: Message, patience_s: float) -> Message:
        """Send a request and wait for its answer; raises the error it holds."""
        self._last_id += 1
        raw = protocol.encode({"id": self._last_id, **message})
        if len(raw) > MAX_LINE_BYTES:
            raise ServiceError(
                f"the request is larger than {MAX_LINE_BYTES // 1024} kB; put the job where the"
                " daemon can read it, for example in /var/lib/deltactl"
            )
        deadline_s = time.monotonic() + patience_s
        with self._explained():
            self._socket.settimeout(patience_s)
            self._socket.sendall(raw)
        while True:
            answer = self.receive(deadline_s)
            if answer.get("id") not in (self._last_id, None) or "ok" not in answer:
                continue  # the answer to a request that was given up, or part of a stream
            if answer["ok"] is True:
                return answer
            raise wire_errors.as_exception(answer.get("error"))

    def receive(self, deadline_s: float) -> Message:
        """The next message. Raises ServiceError at the deadline or the end."""
        while b"\n" not in self._rest:
            with self._explained():
                self._socket.settimeout(max(1e-3, deadline_s - time.monotonic()))
                chunk = self._socket.recv(65_536)
                if not chunk:
                    raise ConnectionResetError
            self._rest += chunk
        line, self._rest = self._rest.split(b"\n", 1)
        with contextlib.suppress(ValueError):
            message = json.loads(line)
            if isinstance(message, dict):
                return message
        raise ServiceError(f"what answers at {self.path} is no daemon of deltactl")

    def close(self) -> None:
        """End the connection."""
        self._socket.close()

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except TimeoutError as error:
            raise ServiceError(
                f"the daemon at {self.path} does not answer in time; see"
                " 'journalctl -u deltactl', or restart it"
            ) from error
        except OSError as error:
            raise ServiceError(
                f"the daemon at {self.path} has ended the connection; see"
                " 'journalctl -u deltactl' for the reason"
            ) from error


def find_daemon(path: Path | None, timeout_s: float) -> tuple[Path, socket.socket] | None:
    """Connect to the first socket where somebody listens; None when nobody does.

    Raises ServiceError when a daemon is there but we may not use it, or it does not let us in.
    """
    for place in client_sockets(path):
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        connection.settimeout(timeout_s)
        try:
            _connect(connection, place, timeout_s)
        except (FileNotFoundError, ConnectionRefusedError, NotADirectoryError):
            connection.close()
        except OSError as error:
            connection.close()
            raise _refused(place, error) from error
        else:
            return place, connection
    return None


def _connect(connection: socket.socket, place: Path, timeout_s: float) -> None:
    """Connect; while too many others are waiting to be let in (EAGAIN, unix(7)), try again."""
    give_up_s = time.monotonic() + timeout_s
    while True:
        try:
            connection.connect(str(place))
            return
        except BlockingIOError:
            if time.monotonic() > give_up_s:
                raise
            time.sleep(RETRY_S)


def _refused(place: Path, error: OSError) -> ServiceError:
    if isinstance(error, PermissionError):
        return ServiceError(
            f"{place}: you may not use this daemon; join its group with"
            " 'sudo usermod -aG deltactl $USER' and log in again"
        )
    return ServiceError(f"{place}: no connection to the daemon ({error.strerror or error})")
