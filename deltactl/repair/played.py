"""A plan as it is played: the counts of every motor over time, and the targets they are for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from deltactl.drivers.steps.contract import Counts
from deltactl.firmware_py.planner.plan import Plan, home_counts, plan_of
from deltactl.firmware_py.planner.stream import MotionStream
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import NS_PER_S
from deltactl.models.robot import ARMS, FloatArray

IntArray = np.ndarray[Any, np.dtype[np.int64]]
HOLD_S = 0.02
"""A rotor that gets no step for longer is at rest; between quicker steps it turns evenly."""
REST_S = 0.5
"""The robot is watched for this long after the last target."""


@dataclass(frozen=True, eq=False)
class Played:
    """Times (n,) [s] and counts (n, 3) after them; targets (k, 3) [m] due at target_s (k,)."""

    due_s: FloatArray
    counts: IntArray
    target_s: FloatArray
    target_m: FloatArray
    t_pwm_s: float

    @property
    def seconds(self) -> float:
        """How long the motion lasts."""
        return float(max(self.due_s[-1], self.target_s[-1])) + REST_S

    def is_same_as(self, other: Played) -> bool:
        """Whether the same counts are sent at the same times for the same targets."""
        pairs = (
            (self.counts, other.counts),
            (self.due_s, other.due_s),
            (self.target_s, other.target_s),
        )
        return all(np.array_equal(mine, theirs) for mine, theirs in pairs)

    def at(self, t_s: FloatArray) -> IntArray:
        """Commanded counts at given times, (n, 3)."""
        row = np.searchsorted(self.due_s, t_s + 1e-9, side="right") - 1
        counts: IntArray = self.counts[np.maximum(row, 0)]
        return counts

    def smooth(self, t_s: FloatArray) -> FloatArray:
        """Counts as rotors turn, (n, 3): half a step done when a step is due."""
        return np.stack([self._rotor(t_s, motor) for motor in range(ARMS)], axis=1)

    def _rotor(self, t_s: FloatArray, motor: int) -> FloatArray:
        count = self.counts[:, motor]
        change = np.diff(count, prepend=count[0])
        moves = np.flatnonzero(change)
        if not len(moves):
            return np.full(len(t_s), float(count[0]))
        due, after = self.due_s[moves], count[moves].astype(np.float64)
        knots_s, knots = [due], [after - 0.5 * change[moves]]
        gap = np.diff(due, append=np.inf)
        stands = gap > HOLD_S
        knots_s.append(due[stands] + 0.5 * HOLD_S)
        knots.append(after[stands])
        again = np.flatnonzero(stands[:-1]) + 1
        first = np.concatenate([[0], again])
        knots_s.append(due[first] - 0.5 * HOLD_S)
        knots.append(after[first] - change[moves][first])
        order = np.argsort(np.concatenate(knots_s), kind="stable")
        turned: FloatArray = np.interp(
            t_s, np.concatenate(knots_s)[order], np.concatenate(knots)[order]
        )
        return turned


def played(plan: Plan, most_s: float = math.inf, from_counts: Counts | None = None) -> Played:
    """A plan from home, or from other counts, on; its first `most_s` at least.

    Raises MotionError where the plan does not hold any more.
    """
    start = from_counts or home_counts(plan.robot)
    due, steps, target_s, target_m = [], [], [], []
    for chunk in MotionStream(plan, start):
        due.append(chunk.ticks.due_ns)
        steps.append(chunk.ticks.steps)
        mine = (chunk.reached.number >= 0) & ~chunk.reached.left
        target_s.append(chunk.reached.t_ns[mine] / NS_PER_S)
        target_m.append(chunk.reached.position_m[mine])
        if len(due[-1]) and due[-1][-1] > most_s * NS_PER_S:
            break
    counts = np.array(start) + np.cumsum(np.concatenate(steps), axis=0, dtype=np.int64)
    timing = plan.job.timing
    return Played(
        due_s=np.concatenate([[0.0], np.concatenate(due) / NS_PER_S]),
        counts=np.vstack([np.array([start]), counts]),
        target_s=np.concatenate(target_s),
        target_m=np.concatenate(target_m),
        t_pwm_s=timing.t_pwm_s if timing.mode == "together" else 0.0,
    )


MOST_KEPT = 3
"""A healing plans a job for the old robot file, the new one, and one between them."""


class Paths:
    """A job as it is played by one robot file or another, worked out once for equal files.

    The files that the job names must not change meanwhile.
    """

    def __init__(self, job: Path, most: int = MOST_KEPT):
        """most: so many are remembered, those that were asked for last."""
        self._job, self._most = job, most
        self._kept: list[tuple[Plan, Played]] = []

    def of(self, robot: RobotFile) -> tuple[Plan, Played]:
        """Plan and counts from home. Raises as `plan_of` and `played` do."""
        found = next((one for one in self._kept if one[0].robot == robot), None)
        if found is None:
            plan = plan_of(self._job, robot)
            found = plan, played(plan)
        else:
            self._kept.remove(found)
        self._kept = [*self._kept, found][-self._most :]
        return found

    def path(self, robot: RobotFile) -> Played:
        """Counts from home."""
        return self.of(robot)[1]


@dataclass(frozen=True, eq=False)
class Drawn:
    """Target and truth (k, 3) [m] at the same times (k,) [s]."""

    t_s: FloatArray
    target_m: FloatArray
    true_m: FloatArray

    @property
    def error_m(self) -> FloatArray:
        """Distance from the target, (k,) [m]."""
        distance: FloatArray = np.linalg.norm(self.true_m - self.target_m, axis=1)
        return distance

    @property
    def rms_m(self) -> float:
        """Root of the mean squared distance [m]."""
        return float(np.sqrt(np.mean(self.error_m**2)))

    @property
    def worst_m(self) -> float:
        """Largest distance [m]."""
        return float(self.error_m.max())


def drawn(job: Played, t_s: FloatArray, position_m: FloatArray) -> Drawn:
    """A run's truth, times (n,) and positions (n, 3), at the targets of the job."""
    true_m = np.stack([np.interp(job.target_s, t_s, column) for column in position_m.T], axis=1)
    return Drawn(job.target_s, job.target_m, true_m)
