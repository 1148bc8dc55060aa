"""The watchdog's food: proof that the loops went on since the last time, and nothing less."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

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
