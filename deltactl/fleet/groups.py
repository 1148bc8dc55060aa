"""Findings that several robots share: a batch of gearboxes, a wrong drawing."""

from __future__ import annotations

import itertools
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.fleet.trends import Course, Trend

FEWEST = 3
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
        """Of all members."""
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
        for one in _alike(sorted(members, key=lambda member: member[2])):
            group = Group(effect, parameter, unit, tuple(member[:3] for member in one))
            if len(group.robots) >= FEWEST:
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
