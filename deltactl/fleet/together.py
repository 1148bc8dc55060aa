"""What the answers of a fleet say together: how a size develops, batches, sister machines."""

from __future__ import annotations

import itertools
import math
import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr, stdtrit

from deltactl.fleet.task import Row
from deltactl.models.effects import VOCABULARY
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
        days = [
            left / rate if rate * left > 0.0 else math.inf
            for rate in (self.per_day, self.low_per_day, self.high_per_day)
        ]
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
    return [
        _course(key, sorted(points, key=lambda point: point[0]), times[key[0]], first)
        for key, points in sorted(found.items())
    ]


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
    columns = {
        name: np.array([float(size[name]) for _, size in points])
        for name in ("value", "low", "high")
    }
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
    reach = float(stdtrit(free, 0.975)) * error
    p = float(2.0 * stdtr(free, -abs(slope) / error)) if error > 0.0 else 0.0
    _, effect, _, parameter = course.key
    limit = limits.get(f"{effect}.{parameter}")
    if limit is not None and limit * at_zero < 0.0:
        limit = -limit
    return Trend(
        course, float(slope), float(slope) - reach, float(slope) + reach, float(at_zero), p, limit
    )


FEWEST_ALIKE = 3
"""Two robots with the same fault may be chance."""
ALIKE = 0.2
"""Sizes of a batch differ by less than this part of themselves, or by their scatter."""


@dataclass(frozen=True)
class Group:
    """Robots with the same effect at about the same size."""

    effect: str
    parameter: str
    unit: str
    members: tuple[tuple[str, str, float], ...]
    """Robot, component, median size."""

    @property
    def robots(self) -> tuple[str, ...]:
        """Each once."""
        return tuple(sorted({robot for robot, _, _ in self.members}))

    @property
    def median(self) -> float:
        """Median size of all members."""
        return float(np.median([size for _, _, size in self.members]))

    @property
    def spread(self) -> float:
        """Standard deviation of the members' sizes."""
        return float(np.std([size for _, _, size in self.members]))


def groups(found: Sequence[Course], moving: Sequence[Trend] = ()) -> list[Group]:
    """The largest first. What still grows or drifts is no batch and is left out."""
    moves = {trend.course.key for trend in moving}
    lasting: dict[tuple[str, str, str, str], list[tuple[str, str, float, float]]] = defaultdict(
        list
    )
    for course in found:
        if course.key in moves or not course.lasts:
            continue
        robot, effect, component, parameter = course.key
        place = re.sub(r"\d+$", "", component)
        if not np.median(course.value):
            continue  # nothing at all, on several: no batch has that
        scatter = 1.48 * float(np.median(np.abs(course.value - np.median(course.value))))
        size = float(np.median(course.value))
        lasting[effect, parameter, course.unit, place].append((robot, component, size, scatter))
    made = []
    for (effect, parameter, unit, _), members in lasting.items():
        for batch in _alike(sorted(members, key=lambda member: member[2])):
            group = Group(effect, parameter, unit, tuple(member[:3] for member in batch))
            if len(group.robots) >= FEWEST_ALIKE:
                made.append(group)
    return sorted(made, key=lambda group: -len(group.robots))


def _alike(
    members: list[tuple[str, str, float, float]],
) -> list[list[tuple[str, str, float, float]]]:
    """Cut sorted sizes where the step to the next is larger than they may differ."""
    cut: list[list[tuple[str, str, float, float]]] = [[members[0]]]
    for before, member in itertools.pairwise(members):
        near = max(ALIKE * abs(before[2]), 2.0 * (before[3] + member[3]))
        if member[2] - before[2] <= near:
            cut[-1].append(member)
        else:
            cut.append([member])
    return cut


WORTH = 4.0
"""The engine's odds count like so many machines."""
USUAL_ODDS = 0.02
"""Prior odds of an effect that is not in the vocabulary."""
FEWEST_RUNS = 3
"""An effect lasts on a machine that has it in LASTING of its recordings, of so many at least."""
MOST = 0.999
"""No share of a fleet makes anything certain."""

Kind = tuple[str, str]
"""Effect, and component without its number."""


@dataclass(frozen=True)
class Sisters:
    """What is known of the other machines of a fleet."""

    machines: Mapping[Kind, int]
    """On how many machines each effect lasts."""
    lasts_on: Mapping[str, frozenset[Kind]]
    """What lasts on each machine that has recordings enough."""

    @classmethod
    def of(cls, rows: Sequence[Row]) -> Sisters:
        """Count over the answers of a fleet."""
        runs: dict[str, int] = defaultdict(int)
        found: dict[tuple[str, Kind], int] = defaultdict(int)
        for row in rows:
            if "error" in row:
                continue
            runs[row["robot"]] += 1
            for kind in {_kind(size) for size in row["findings"]}:
                found[row["robot"], kind] += 1
        lasts_on = {
            robot: frozenset(
                kind
                for (of, kind), times in found.items()
                if of == robot and times >= LASTING * count
            )
            for robot, count in runs.items()
            if count >= FEWEST_RUNS
        }
        machines: dict[Kind, int] = defaultdict(int)
        for kinds in lasts_on.values():
            for kind in kinds:
                machines[kind] += 1
        return cls(dict(machines), lasts_on)

    def having(self, robot: str, kind: Kind) -> tuple[int, int]:
        """On how many sisters of a robot an effect lasts, and how many sisters there are."""
        own = self.lasts_on.get(robot)
        having = self.machines.get(kind, 0) - (own is not None and kind in own)
        return having, len(self.lasts_on) - (own is not None)

    def ratio(self, robot: str, kind: Kind) -> float:
        """Odds that a sister has an effect, over those the engine took."""
        having, sisters = self.having(robot, kind)
        taken = VOCABULARY[kind[0]].odds if kind[0] in VOCABULARY else USUAL_ODDS
        share = (having + WORTH * taken / (1.0 + taken)) / (sisters + WORTH)
        return share / (1.0 - share) / taken


def sharpened(rows: Sequence[Row]) -> list[Row]:
    """The same answers with probabilities that count the sisters; what was said alone is kept.

    Each size of a finding gains `alone` (its probability by itself), `sisters` (in words) and
    `rather` (what the sisters make more likely than it, or nothing).
    """
    known = Sisters.of(rows)

    def counted(row: Row) -> Row:
        if "error" in row:
            return row
        return row | {"findings": [_sharper(known, row["robot"], size) for size in row["findings"]]}

    return [counted(row) for row in rows]


def _sharper(known: Sisters, robot: str, size: Row) -> Row:
    alone = size.get("probability")
    if alone is None:
        return size
    its = _kind(size)
    alternatives = [
        alternative
        for alternative in size.get("alternatives", ())
        if alternative["probability"] is not None
    ]
    weights = [alone * known.ratio(robot, its)]
    weights += [
        alternative["probability"] * known.ratio(robot, _kind(alternative))
        for alternative in alternatives
    ]
    neither = max(
        0.0, 1.0 - alone - sum(alternative["probability"] for alternative in alternatives)
    )
    total = sum(weights) + neither
    best = max(range(len(weights)), key=weights.__getitem__)
    rather = alternatives[best - 1] if best else None
    having, sisters = known.having(robot, its)
    return size | {
        "alone": alone,
        "probability": min(MOST, weights[0] / total) if total > 0.0 else alone,
        "sisters": f"lasts on {having} of {sisters} sisters",
        "rather": f"{rather['effect']} at {rather['component']}" if rather else None,
    }


def _kind(size: Row) -> Kind:
    return size["effect"], re.sub(r"\d+$", "", size["component"])
