"""The feedback of one running job: sees edges and readings, and adds steps to those of the plan."""

from __future__ import annotations

from collections import deque
from itertools import product

import numpy as np

from deltactl.drivers.ranging.contract import Gate, Reading
from deltactl.drivers.steps.contract import MOTORS, Counts, Int64Array, Ticks
from deltactl.firmware_py.feedback.estimator import Estimate, SlowErrors
from deltactl.firmware_py.feedback.residuals import Expectation, Residuals
from deltactl.firmware_py.feedback.settings import FeedbackSettings
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import ns
from deltactl.models.linkage import Linkage, forward, jacobian
from deltactl.models.robot import ARMS, DeltaRobot, FloatArray, per_arm

LOOK_S = 0.1
BASELINE_S = 3.0
"""Errors are counted from what they were on average this long after the job began."""
SIGMAS = 4.0
REFINED = 0.2
"""A correction changes when it is off by this share of `least_m`, and by `SIGMAS`."""
ROOM_S = 0.0004
"""An extra tick keeps this far from those of the plan."""


class Feedback:
    """See FeedbackSettings. `note` is what there is to say of it, once."""

    def __init__(self, robot: RobotFile, settings: FeedbackSettings, counts: Counts, now_ns: int):
        self._settings = settings
        self._expected = Expectation(robot)
        self._expected.reset(counts, now_ns)
        self._errors = SlowErrors()
        self._readings: deque[Reading] = deque(maxlen=1000)
        step_m = robot.drive.rad_per_step * per_arm(robot.geometry.upper_arm_m)
        self._steps_per_rad = 1.0 / robot.drive.rad_per_step
        self._least = settings.least_m / step_m
        self._most = np.floor(settings.most_m / step_m)
        self._begun_ns = self._looked_ns = now_ns
        self._baseline_rad: FloatArray | None = None
        self._goal = np.zeros(MOTORS, dtype=np.int64)
        self._every_ns = ns(1.0 / settings.steps_hz)
        slowest = robot.steps.shortest_period_s if robot.steps.backend == "gpiozero" else 0.0
        self._room_ns = ns(max(ROOM_S, slowest))
        self._last_ns = now_ns
        self.offset: Int64Array = np.zeros(MOTORS, dtype=np.int64)
        """Steps added to the plan's so far, (3,)."""
        self.suspect = ""
        self.corrected = False

    def sent(self, ticks: Ticks) -> None:
        """Edges really sent."""
        if len(ticks):
            self._expected.sent(ticks)

    def reading(self, reading: Reading) -> None:
        """A sample of a sensor; only good ones count."""
        if reading.gate is Gate.GOOD:
            self._readings.append(reading)

    def trim(self, ticks: Ticks, now_ns: int) -> Ticks:
        """The ticks with what is to be added now between them, at run times of the clock."""
        self._look(now_ns)
        missing = self._goal - self.offset
        if len(ticks) < 2 or not missing.any():
            return ticks
        due, steps = ticks.due_ns, ticks.steps
        at = np.flatnonzero(np.diff(due) >= 2 * self._room_ns)
        extra_ns, extra = [], []
        for middle in (due[at] + (due[at + 1] - due[at]) // 2).tolist():
            if middle < self._last_ns + self._every_ns:
                continue
            step = np.sign(missing)
            if not step.any():
                break
            extra_ns.append(middle)
            extra.append(step.astype(np.int8))
            missing = missing - step
            self.offset = self.offset + step
            self._last_ns = middle
        if not extra_ns:
            return ticks
        self.corrected = True
        every_ns = np.concatenate([due, np.array(extra_ns, dtype=np.int64)])
        order = np.argsort(every_ns, kind="stable")
        return Ticks(every_ns[order], np.concatenate([steps, np.array(extra)])[order])

    def planned(self, counts: Counts) -> Counts:
        """Counts without the steps that were added."""
        first, second, third = (np.array(counts) - self.offset).tolist()
        return first, second, third

    def corrects(self, motor: int) -> bool:
        """Whether steps are added to those of a motor (1 to 3)."""
        return bool(self._goal[motor - 1])

    def says(self) -> str:
        """What it did and found, in one line; empty where that is nothing."""
        parts = []
        if self.corrected:
            added = ", ".join(str(count) for count in self.offset.tolist())
            parts.append(f"feedback added {added} steps to the three motors")
        if self.suspect:
            parts.append(
                f"sensor {self.suspect} contradicted the others for a while: nothing was corrected"
            )
        return "; ".join(parts)

    def _look(self, now_ns: int) -> None:
        if now_ns - self._looked_ns < ns(LOOK_S):
            return
        self._looked_ns = now_ns
        new = [self._readings.popleft() for _ in range(len(self._readings))]
        rows: Residuals = self._expected.residuals(new)
        self._expected.forget(now_ns)
        found = self._errors.look(rows, now_ns)
        if found is None or now_ns - self._begun_ns < ns(BASELINE_S):
            return
        if self._baseline_rad is None:
            self._baseline_rad = found.error_rad.copy()
        self._aim(found)

    def _aim(self, found: Estimate) -> None:
        """Decide what is to be added; nothing new while a sensor may be the liar."""
        self.suspect = found.suspect or self.suspect
        if found.suspect or self._baseline_rad is None:
            return
        wanted = -(found.error_rad - self._baseline_rad) * self._steps_per_rad
        doubt = SIGMAS * found.sigma_rad * self._steps_per_rad
        engaged = (np.abs(wanted) > np.maximum(self._least, doubt)) | (self._goal != 0)
        moves = np.abs(wanted - self._goal) > np.maximum(REFINED * self._least, doubt)
        bounded = np.clip(np.rint(wanted), -self._most, self._most).astype(np.int64)
        self._goal = np.where(engaged & moves, bounded, self._goal)


LOOKED_AT = 500


def farthest_m(robot: DeltaRobot, settings: FeedbackSettings, angles_rad: FloatArray) -> float:
    """Largest way of the platform [m] with all arms corrected by the most, over a path (n, 3).

    Whatever the sensors say: `most_m` bounds each arm, here the arms are off in the worst way.
    """
    every = max(1, len(angles_rad) // LOOKED_AT)
    linkage, looked = Linkage.of(robot.geometry), angles_rad[::every]
    slopes = jacobian(linkage, looked, forward(linkage, looked).position_m)
    most_rad = settings.most_m / per_arm(robot.geometry.upper_arm_m)
    ways = np.array(list(product((-1.0, 1.0), repeat=ARMS))) * most_rad
    moved_m = np.einsum("nij,kj->nki", slopes, ways)
    return float(np.nanmax(np.linalg.norm(moved_m, axis=2)))
