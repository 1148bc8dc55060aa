"""sd_notify(3) and the watchdog: tells systemd that the service is ready, alive, ending.

Without NOTIFY_SOCKET every call does nothing. What cannot be sent is dropped: the robot
must not stop because its service manager does not listen.
"""

from __future__ import annotations

import logging
import os
import socket
import time
from collections.abc import Callable, MutableMapping

from deltactl.foundation.printable import printable

_log = logging.getLogger(__name__)

FEEDS_PER_LIMIT = 3
"""Progress is looked for so often within the watchdog's limit (sd_watchdog_enabled(3): twice)."""


class Watchdog:
    """Feeds only when `progress` has grown since the last feed and the server still serves.

    A controller whose loops hang stops feeding itself, even if this thread goes on: the
    service manager then ends the daemon, and ExecStopPost makes the lines safe.
    """

    def __init__(
        self,
        progress: Callable[[], int],
        feed: Callable[[], None],
        serving: Callable[[], bool] = lambda: True,
    ):
        self._progress, self._feed, self._serving = progress, feed, serving
        self._seen = progress()
        self._moved_s = time.monotonic()

    def check(self) -> bool:
        """Feed if there is proof; tells whether it did."""
        count = self._progress()
        if count <= self._seen or not self._serving():
            _log.debug("no progress for %.2f s", time.monotonic() - self._moved_s)
            return False
        self._seen = count
        self._moved_s = time.monotonic()
        self._feed()
        return True

    @property
    def quiet_s(self) -> float:
        """How long there has been no proof."""
        return time.monotonic() - self._moved_s


def check_period_s(limit_s: float | None) -> float:
    """How often to check: a third of the limit, half a second where there is none."""
    return 0.5 if limit_s is None else min(0.5, limit_s / FEEDS_PER_LIMIT)


_log = logging.getLogger(__name__)
USEC_PER_S = 1_000_000
PATIENCE_S = 0.1
"""The manager's queue may be full for a moment; a hanging manager must not hold us up."""


class Notifier:
    """Sends datagrams to the service manager; knows how often it wants to hear from us."""

    def __init__(self, address: str | None = None, watchdog_s: float | None = None):
        self.watchdog_s = watchdog_s
        """The watchdog's limit; None when there is no watchdog."""
        self._address = _socket_name(address) if address else None
        self._told = ""
        self._lost = False
        """Whether the last message did not go out; said once, not every time."""
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
        self._socket.settimeout(PATIENCE_S)

    @classmethod
    def from_environment(cls, environment: MutableMapping[str, str] | None = None) -> Notifier:
        """Take NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID out, so that no child uses them."""
        variables = os.environ if environment is None else environment
        address = variables.pop("NOTIFY_SOCKET", None)
        limit_usec = variables.pop("WATCHDOG_USEC", "")
        meant_for = variables.pop("WATCHDOG_PID", str(os.getpid()))
        watchdog_s = None
        if limit_usec.isdigit() and int(limit_usec) > 0 and meant_for == str(os.getpid()):
            watchdog_s = int(limit_usec) / USEC_PER_S
        return cls(address, watchdog_s)

    def ready(self) -> None:
        """Clients may come."""
        self._send("READY=1")

    def status(self, text: str) -> None:
        """One line for `systemctl status`; sent when it has changed."""
        line = printable(" ".join(text.split()))
        if line != self._told:
            self._told = line
            self._send(f"STATUS={line}")

    def alive(self) -> None:
        """Feed the watchdog."""
        self._send("WATCHDOG=1")

    def stopping(self) -> None:
        """The service is on its way down."""
        self._send("STOPPING=1")

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()

    def _send(self, text: str) -> None:
        if self._address is None:
            return
        try:
            self._socket.sendto(text.encode(), self._address)
        except OSError as error:
            if not self._lost:
                _log.warning("the service manager did not get %s: %s", text, error)
            self._lost = True
        else:
            self._lost = False


def _socket_name(address: str) -> str:
    """`@name` means an abstract socket, as in sd_notify(3)."""
    return "\0" + address[1:] if address.startswith("@") else address
