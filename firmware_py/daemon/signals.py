"""SIGTERM and SIGINT as something the main thread can wait for."""

from __future__ import annotations

import os
import select
import signal
from types import FrameType
from typing import Any

ASKED_TO_END = (signal.SIGTERM, signal.SIGINT)


class EndSignals:
    """While active, counts the signals that ask the daemon to end. Main thread only.

    A pipe, not an Event: a handler may run while its own thread holds the Event's lock.
    """

    def __init__(self) -> None:
        self.count = 0
        self._reader, self._writer = os.pipe2(os.O_CLOEXEC | os.O_NONBLOCK)
        self._before: dict[int, Any] = {}

    def wait(self, timeout_s: float) -> None:
        """Return at the next signal, or when the time is over."""
        if select.select([self._reader], [], [], timeout_s)[0]:
            os.read(self._reader, 64)

    def __enter__(self) -> EndSignals:
        self._before = {one: signal.signal(one, self._came) for one in ASKED_TO_END}
        return self

    def __exit__(self, *_: object) -> None:
        for one, handler in self._before.items():
            signal.signal(one, handler)
        os.close(self._reader)
        os.close(self._writer)

    def _came(self, number: int, frame: FrameType | None) -> None:
        self.count += 1
        os.write(self._writer, b"!")
