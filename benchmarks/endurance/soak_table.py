"""What a soak measures again and again, and the table of it."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from tests.rigs.faults.vitals import Vitals

MOST_SHOWN = 300
_NUMBERS = re.compile(r"[0-9]+(?:[-.T:][0-9]+)*")
WARM_UP = 0.15
"""The first part of a soak loads, fills buffers and caches: slopes are taken after it."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One look. `drift`: worst difference of counters and drives [steps]."""

    hours: float
    vitals: Vitals
    drift: int
    edges_missed: int
    recordings: int
    recorded_mb: float
    oldest_s: float
    free_mb: float


@dataclass
class Tally:
    """What happened, and what was wrong."""

    samples: list[Sample] = field(default_factory=list)
    happened: dict[str, int] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    def count(self, what: str, times: int = 1) -> None:
        """Something happened."""
        self.happened[what] = self.happened.get(what, 0) + times

    def rows(self) -> list[str]:
        """The table."""
        hours = np.array([one.hours for one in self.samples])
        late = hours >= WARM_UP * hours[-1]
        rows = [f"{'':28}{'first':>12}{'last':>12}{'worst':>12}{'slope an hour':>16}"]
        for name, values in self._columns().items():
            slope = np.polyfit(hours[late], values[late], 1)[0] if late.sum() > 2 else np.nan
            figures = (values[late][0], values[-1], values.max())
            rows.append(f"{name:28}" + "".join(f"{v:12.1f}" for v in figures) + f"{slope:16.3f}")
        rows.append("  ".join(f"{what}: {n}" for what, n in sorted(self.happened.items())))
        kinds = Counter(_NUMBERS.sub("*", problem)[:MOST_SHOWN] for problem in self.problems)
        return [*rows, *(f"NOT AS IT SHOULD BE, {n} times: {kind}" for kind, n in kinds.items())]

    def _columns(self) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
        of = self.samples
        return {
            "resident memory, MB": np.array([s.vitals.rss_kb / 1024 for s in of]),
            "open files": np.array([float(s.vitals.files) for s in of]),
            "threads": np.array([float(s.vitals.threads) for s in of]),
            "counter against drive, steps": np.array([float(s.drift) for s in of]),
            "edges not yet reported": np.array([float(s.edges_missed) for s in of]),
            "recordings": np.array([float(s.recordings) for s in of]),
            "recordings, MB": np.array([s.recorded_mb for s in of]),
            "oldest recording, s (wall)": np.array([s.oldest_s for s in of]),
            "free on the disk, MB": np.array([s.free_mb for s in of]),
        }
