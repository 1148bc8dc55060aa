"""How long recordings are kept: settings, and the thread that keeps to them."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

from pydantic import Field

from deltactl.foundation.strict_yaml import StrictModel
from deltactl.recording.writing.retention import prune

GIB = 2**30
DAY_S = 86_400.0
LOOK_S = 60.0
"""A minute of recording is some 2 MB: no limit is passed by more than that."""

_log = logging.getLogger(__name__)


class KeptRecordings(StrictModel):
    """What the daemon keeps in its folder of recordings; the oldest go first, the newest never."""

    max_gib: Annotated[
        float, Field(ge=0.01, le=1e5, description="GiB; an hour of running is about 0.06")
    ] = 16.0
    """All recordings together."""
    max_age_days: (
        Annotated[float, Field(ge=0.001, le=36_500.0, description="days; a minute to a century")]
        | None
    ) = None
    """Absent: as long as there is room."""
    keep_free_gib: Annotated[
        float, Field(ge=0.0, le=1e5, description="GiB; below 0.06 no recording is begun")
    ] = 1.0
    """Left free on that disk: a Pi with a full card does not boot."""


class RecordingKeeper:
    """Deletes what may no longer stay, now and then, in a thread of its own.

    What cannot be deleted is left and looked at again the next time; nothing is ever raised.
    """

    def __init__(
        self,
        folder: Path,
        kept: KeptRecordings,
        now_s: Callable[[], float] = time.time,
        period_s: float = LOOK_S,
    ):
        self._folder, self._kept = folder, kept
        self._now_s, self._period_s = now_s, period_s
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="recordings", daemon=True)

    def start(self) -> None:
        """Begin, with a look at once."""
        self._thread.start()

    def close(self, timeout_s: float = 2.0) -> None:
        """End; safe without `start`, and twice."""
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join(timeout_s)

    def tidy(self) -> list[Path]:
        """Look once; returns what was deleted."""
        kept, days = self._kept, self._kept.max_age_days
        try:
            gone = prune(
                self._folder,
                max_bytes=round(kept.max_gib * GIB),
                max_age_s=None if days is None else days * DAY_S,
                keep_free_bytes=round(kept.keep_free_gib * GIB),
                now_s=self._now_s(),
            )
        except OSError as error:
            _log.warning("%s: cannot be looked through (%s)", self._folder, error.strerror)
            return []
        for path in gone:
            _log.info("%s: deleted to make room, as 'recordings' of the robot file says", path)
        return gone

    def _run(self) -> None:
        while True:
            self.tidy()
            if self._ending.wait(self._period_s):
                return
