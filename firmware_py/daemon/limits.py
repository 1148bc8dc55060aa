"""What one client may cost the daemon, as numbers, and the means to keep to them."""

from __future__ import annotations

import time
from dataclasses import dataclass

from deltactl.firmware_py.daemon.protocol import MAX_LINE_BYTES


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds of the server; tests make the times shorter."""

    clients: int = 16
    stop_only_clients: int = 4
    """When all places are taken, so many more are let in for a stop and nothing else."""
    requests_hz: float = 100.0
    burst: int = 200
    refusals: int = 1000
    """A client that was over its rate so often is cut off."""
    slow_down_s: float = 0.05
    """Pause after each read while a client is over its rate."""
    waiting_answers: int = 256
    waiting_commands: int = 16
    answer_s: float = 1.0
    """A job whose check takes longer is answered with 'planning', and its result asked for."""
    send_s: float = 2.0
    """A client that does not read for so long is cut off."""
    half_line_s: float = 5.0
    idle_s: float = 600.0
    stop_only_idle_s: float = 5.0


class Allowance:
    """A token bucket: `burst` requests at once, then `rate_hz`."""

    def __init__(self, rate_hz: float, burst: int):
        self._rate_hz, self._burst = rate_hz, float(burst)
        self._tokens = float(burst)
        self._at_s = time.monotonic()

    def take(self) -> bool:
        """Take one; False when there is none left."""
        now_s = time.monotonic()
        self._tokens = min(self._burst, self._tokens + (now_s - self._at_s) * self._rate_hz)
        self._at_s = now_s
        if self._tokens < 1.0:
            return False
        self._tokens -= 1.0
        return True

    def give_back(self) -> None:
        """Undo one take."""
        self._tokens = min(self._burst, self._tokens + 1.0)


class Lines:
    """Cuts a stream into lines; a line that is too long comes out as None and is skipped."""

    def __init__(self, most_bytes: int = MAX_LINE_BYTES):
        self._most = most_bytes
        self._rest = b""
        self._skipping = False

    @property
    def half(self) -> bool:
        """Whether the beginning of a line has come and its end has not."""
        return bool(self._rest) or self._skipping

    def feed(self, chunk: bytes) -> list[bytes | None]:
        """Complete lines in what has come so far; empty lines are left out."""
        found: list[bytes | None] = []
        *whole, self._rest = (self._rest + chunk).split(b"\n")
        for line in whole:
            if self._skipping:
                self._skipping = False
            elif len(line) > self._most:
                found.append(None)
            elif line.strip():
                found.append(line)
        if self._skipping:
            self._rest = b""
        elif len(self._rest) > self._most:
            found.append(None)
            self._rest, self._skipping = b"", True
        return found
