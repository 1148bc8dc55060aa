"""What the page has seen of the robot: how jobs ended, and the newest minutes as curves."""

from __future__ import annotations

import json
import math
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Final

from deltactl.firmware_py.controller.contract import JobResult, SensorStatus, Status
from deltactl.foundation.plain_file import write_whole
from deltactl.models.linkage.vectors import Vector

MOST: Final = 200
"""Ended jobs that are remembered."""


@dataclass(frozen=True, slots=True)
class Ended:
    """A job that has ended: how, when it began (seconds since 1970), and how long it took."""

    name: str
    outcome: str
    why: str
    recording: str
    """File name; empty where nothing was recorded."""
    began_s: float
    duration_s: float
    warning: str = ""

    @classmethod
    def of(cls, result: JobResult, began_s: float, ended_s: float) -> Ended:
        """From what the daemon says of it."""
        recording = Path(result.recording).name if result.recording else ""
        lasted_s = round(max(0.0, ended_s - began_s), 2)
        why, warning = result.why, result.warning
        return cls(result.name, result.outcome, why, recording, began_s, lasted_s, warning)


class History:
    """The newest ended jobs, the newest first; kept in a file, as the page may be started anew."""

    def __init__(self, note: Path):
        self._note = note
        self._ended: deque[Ended] = deque(maxlen=MOST)
        with suppress(OSError, ValueError, TypeError):
            known = json.loads(note.read_text(encoding="utf-8"))
            self._ended.extend(Ended(**one) for one in known)

    def newest_first(self) -> list[Ended]:
        """All that is remembered."""
        return list(self._ended)

    def add(self, ended: Ended) -> None:
        """Remember one more."""
        self._ended.appendleft(ended)
        with suppress(OSError):  # a full disk must not end the watch
            self._note.parent.mkdir(parents=True, exist_ok=True)
            write_whole(self._note, json.dumps([asdict(one) for one in self._ended]))

    def renamed(self, recording: str, name: str) -> None:
        """Follow the new name of a recording; an empty one: it was deleted."""
        for place, one in enumerate(self._ended):
            if one.recording == recording:
                values = asdict(one) | {"recording": name}
                self._ended[place] = Ended(**values)


PERIOD_S: Final = 0.2
KEPT_S: Final = 120.0
Measured = Callable[[tuple[SensorStatus, ...]], Vector | None]


@dataclass
class Curves:
    """Curves by name, each with a value for every time; None where there is none."""

    t_s: list[float] = field(default_factory=list)
    values: dict[str, list[float | None]] = field(default_factory=dict)

    def last(self, seconds: float) -> Curves:
        """The newest part."""
        least = (self.t_s[-1] if self.t_s else 0.0) - seconds
        first = next((place for place, t_s in enumerate(self.t_s) if t_s >= least), 0)
        return Curves(self.t_s[first:], {name: row[first:] for name, row in self.values.items()})


class Trace:
    """The newest two minutes of what the daemon says, five times a second.

    Lengths are in mm, rates in steps/s. The error is the distance between where the sensors see
    the platform and where the step counts put it, as no status says which target a reading is of.
    """

    def __init__(self) -> None:
        self._samples: deque[tuple[float, dict[str, float | None]]] = deque(
            maxlen=round(KEPT_S / PERIOD_S)
        )
        self._before: Status | None = None

    def note(self, status: Status, measured: Measured) -> None:
        """Take a sample, where the last is long enough ago."""
        before = self._before
        if before is not None and 0.0 <= status.time_s - before.time_s < PERIOD_S * 0.99:
            return
        if before is not None and status.time_s < before.time_s:
            self._samples.clear()  # another daemon, whose clock is its own
            before = None
        self._before = status
        self._samples.append((status.time_s, _sample(status, before, measured(status.sensors))))

    def curves(self) -> Curves:
        """All samples; the time is counted from the newest, so that it is 0 or less."""
        samples = list(self._samples)
        if not samples:
            return Curves()
        names = list(samples[-1][1])
        values = {name: [sample.get(name) for _, sample in samples] for name in names}
        newest_s = samples[-1][0]
        return Curves([round(t_s - newest_s, 2) for t_s, _ in samples], values)


def _sample(
    status: Status, before: Status | None, measured_m: Vector | None
) -> dict[str, float | None]:
    sample: dict[str, float | None] = {}
    at_m = status.position_m
    for axis, name in enumerate("xyz"):
        sample[name] = None if at_m is None else round(1e3 * at_m[axis], 3)
    both = at_m is not None and measured_m is not None
    sample["error"] = round(1e3 * math.dist(at_m or (), measured_m or ()), 3) if both else None
    ranges = {sensor.axis: sensor.distance_m for sensor in status.sensors if sensor.gate == "good"}
    for name in "xyz":
        distance_m = ranges.get(name)
        sample[f"range {name}"] = None if distance_m is None else round(1e3 * distance_m, 1)
    for motor in range(3):
        rate = None
        if before is not None and status.time_s > before.time_s:
            steps = status.counts[motor] - before.counts[motor]
            rate = round(steps / (status.time_s - before.time_s), 1)
        sample[f"motor {motor + 1}"] = rate
    return sample


class Watcher:
    """Notes when a job begins, and adds it to the history when the daemon says how it ended."""

    def __init__(self, history: History):
        self._history = history
        self._began_s: dict[int, float] = {}
        self._until_s: dict[int, float] = {}
        self._noted: JobResult | None = None

    def note(self, status: Status, ended: JobResult | None) -> None:
        """Follow one status."""
        now_s = time.time()
        if status.job_id is not None:
            self._began_s.setdefault(status.job_id, now_s)
            self._until_s[status.job_id] = now_s
        if ended is None or ended is self._noted:
            return
        self._noted = ended
        began_s = self._began_s.pop(ended.job_id, now_s)
        self._history.add(Ended.of(ended, began_s, self._until_s.pop(ended.job_id, now_s)))
