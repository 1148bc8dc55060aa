"""How a size develops: a straight line through what was found, with its interval."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from deltactl.fleet.book import Row
from deltactl.models.robot import FloatArray

DAY_S = 86_400.0
FEWEST, SHORTEST_DAYS = 6, 7.0
"""A line through fewer points, or over less than a week, says nothing about weeks."""
ALARM = 0.01
"""Probability that a fleet without any trend shows one, all its series together (Bonferroni)."""
LASTING, OFTEN = 0.5, 3
"""What was found in half of a robot's recordings since it was first found, and so often, lasts."""
Key = tuple[str, str, str, str]
"""Robot, effect, component, parameter."""


@dataclass(frozen=True)
class Course:
    """What was found of one size on one robot, in the order of time. Arrays (n,)."""

    key: Key
    unit: str
    time_s: FloatArray
    value: FloatArray
    low: FloatArray
    high: FloatArray
    recordings: int
    """Good recordings of this robot over the same time, also those where it was not found."""
    main: bool = True
    """Whether it is what its effect is measured by, and not a figure beside that (a phase)."""

    @property
    def found_in(self) -> float:
        """Part of the recordings, from the first finding on, in which it was found."""
        return len(self.value) / max(1, self.recordings)

    @property
    def lasts(self) -> bool:
        """Whether it is the size of something that is there to stay."""
        return self.main and len(self.value) >= OFTEN and self.found_in >= LASTING

    @property
    def name(self) -> str:
        """For people."""
        robot, effect, component, parameter = self.key
        return f"{robot}: {effect.replace('_', ' ')} of {component}, {parameter}"


@dataclass(frozen=True)
class Trend:
    """A course that rises or falls. Rates in its unit a day, with 95 % interval."""

    course: Course
    per_day: float
    low_per_day: float
    high_per_day: float
    now: float
    p: float
    limit: float | None = None

    def days_to_limit(self) -> tuple[float, float, float] | None:
        """Days from the last recording until the limit: best, soonest, latest (may be infinite).

        None without a limit, or when it moves away from it.
        """
        if self.limit is None:
            return None
        left = self.limit - self.now
        if left * self.per_day <= 0.0:
            return (0.0, 0.0, 0.0) if abs(self.now) >= abs(self.limit) else None
        days = [left / rate if rate * left > 0.0 else math.inf for rate in
                (self.per_day, self.low_per_day, self.high_per_day)]  # fmt: skip
        return days[0], min(days[1:]), max(days[1:])


def courses(rows: Sequence[Row]) -> list[Course]:
    """One for each size of each robot that was found at least once."""
    found: dict[Key, list[tuple[float, Row]]] = defaultdict(list)
    times: dict[str, list[float]] = defaultdict(list)
    first: dict[str, str] = {}
    for row in rows:
        if "error" in row:
            continue
        times[row["robot"]].append(row["time_s"])
        for size in row["findings"]:
            # The parameter by which an effect is measured comes first in its finding.
            first.setdefault(_named(size), size["parameter"].partition("[")[0])
            if size["value"] is not None and math.isfinite(size["value"]):
                key = (row["robot"], size["effect"], size["component"], size["parameter"])
                found[key].append((row["time_s"], size))
    return [_course(key, sorted(points, key=lambda point: point[0]), times[key[0]], first)
            for key, points in sorted(found.items())]  # fmt: skip


def _named(size: Row) -> str:
    """The effect as its recording named it."""
    return str(size.get("named", size["effect"]))


def trends(found: Sequence[Course], limits: dict[str, float]) -> list[Trend]:
    """Those that rise or fall for sure, soonest at their limit first.

    limits: "effect.parameter" -> the size that may not be reached, in the unit of the answer.
    """
    tested = [line for course in found if (line := _line(course, limits)) is not None]
    sure = [line for line in tested if line.p < ALARM / max(1, len(tested))]

    def urgency(line: Trend) -> float:
        days = line.days_to_limit()
        return math.inf if days is None else days[0]

    return sorted(sure, key=lambda line: (urgency(line), -abs(line.per_day / (line.now or 1.0))))


def _course(
    key: Key, points: list[tuple[float, Row]], times_s: list[float], first: dict[str, str]
) -> Course:
    columns = {name: np.array([float(size[name]) for _, size in points])
               for name in ("value", "low", "high")}  # fmt: skip
    since = sum(time_s >= points[0][0] for time_s in times_s)
    time_s = np.array([time_s for time_s, _ in points])
    main = key[3].partition("[")[0] == first[_named(points[0][1])]
    return Course(key, points[0][1]["unit"], time_s, **columns, recordings=since, main=main)


def _line(course: Course, limits: dict[str, float]) -> Trend | None:
    """Weighted least squares; scatter beyond the intervals widens the interval of the slope."""
    days = (course.time_s - course.time_s[-1]) / DAY_S
    if len(days) < FEWEST or -days[0] < SHORTEST_DAYS:
        return None
    sigma = (course.high - course.low) / 3.92
    usable = np.isfinite(sigma) & (sigma > 0.0)
    sigma = np.where(usable, sigma, np.median(sigma[usable]) if usable.any() else 1.0)
    design = np.stack([np.ones_like(days), days], axis=1) / sigma[:, None]
    inverse = np.linalg.inv(design.T @ design)
    at_zero, slope = inverse @ (design.T @ (course.value / sigma))
    rest = course.value / sigma - design @ np.array([at_zero, slope])
    free = len(days) - 2
    spread = math.sqrt(max(1.0 if usable.any() else 0.0, float(rest @ rest) / free))
    error = math.sqrt(inverse[1, 1]) * spread
    reach = float(stats.t.ppf(0.975, free)) * error
    p = float(2.0 * stats.t.sf(abs(slope) / error, free)) if error > 0.0 else 0.0
    _, effect, _, parameter = course.key
    limit = limits.get(f"{effect}.{parameter}")
    if limit is not None and limit * at_zero < 0.0:
        limit = -limit
    return Trend(course, float(slope), float(slope) - reach, float(slope) + reach,
                 float(at_zero), p, limit)  # fmt: skip
