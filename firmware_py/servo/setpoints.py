"""Set-points that were asked for, as a smooth reference of the arms.

A tick says that an arm's angle passes half a count at that instant (see
planner/timing_accelerated.py), so the angle is known exactly then; in between it is taken as
straight. Nothing is invented ahead of the newest set-point: there the reference stands still.
"""

from __future__ import annotations

import numpy as np

from drivers.current.contract import JOINTS, Three
from drivers.steps.contract import Counts, Ticks
from models.robot import FloatArray

NOTHING = Ticks(np.empty(0, dtype=np.int64), np.empty((0, JOINTS), dtype=np.int8))


class Setpoints:
    """A queue of ticks; `references_rad` walks along it."""

    def __init__(self, rad_per_step: float):
        self._step_rad = rad_per_step
        self._sent: list[Ticks] = []
        self.restart((0, 0, 0), 0)

    def restart(self, counts: Counts, now_ns: int) -> None:
        """Forget what is queued: the arms are asked to be where the counts say."""
        self.counts = counts
        self._ticks = NOTHING
        self._after = np.empty((0, JOINTS), dtype=np.int64)
        self._known = [(np.array([float(now_ns)]), np.array([float(one)])) for one in counts]

    def __len__(self) -> int:
        return len(self._ticks)

    def push(self, ticks: Ticks, now_ns: int) -> None:
        """Queue ticks, all due after `now_ns`."""
        last = self._after[-1] if len(self._after) else np.array(self.counts)
        after = last + np.cumsum(ticks.steps, axis=0, dtype=np.int64)
        for motor in range(JOINTS):
            stepped = ticks.steps[:, motor] != 0
            half = after[stepped, motor] - 0.5 * ticks.steps[stepped, motor]
            times, places = self._known[motor]
            if times[-1] < now_ns:  # it stood still since
                times, places = np.append(times[-1:], now_ns), places[[-1, -1]]
            self._known[motor] = (
                np.concatenate([times, ticks.due_ns[stepped]]),
                np.concatenate([places, half]),
            )
        self._ticks = Ticks(
            np.concatenate([self._ticks.due_ns, ticks.due_ns]),
            np.concatenate([self._ticks.steps, ticks.steps]),
        )
        self._after = np.concatenate([self._after, after])

    def references_rad(self, times_ns: FloatArray) -> list[list[float]]:
        """The arms' references at increasing times (n,): three lists of n; earlier is forgotten."""
        passed = int(np.searchsorted(self._ticks.due_ns, times_ns[-1], side="right"))
        if passed:
            self._pass(passed)
        found = []
        for motor, (times, places) in enumerate(self._known):
            if len(times) == 1:
                found.append([float(places[0]) * self._step_rad] * len(times_ns))
                continue
            found.append((np.interp(times_ns, times, places) * self._step_rad).tolist())
            keep = int(np.searchsorted(times, times_ns[-1], side="right")) - 1
            if keep > 0:
                self._known[motor] = (times[keep:], places[keep:])
        return found

    def take_sent(self) -> Ticks:
        """Ticks that were passed since the last call."""
        sent, self._sent = self._sent, []
        if not sent:
            return NOTHING
        return Ticks(
            np.concatenate([one.due_ns for one in sent]),
            np.concatenate([one.steps for one in sent]),
        )

    def references_now_rad(self) -> Three:
        """Where the counts put the arms."""
        first, second, third = self.counts
        return first * self._step_rad, second * self._step_rad, third * self._step_rad

    def _pass(self, passed: int) -> None:
        first, second, third = self._after[passed - 1].tolist()
        self.counts = (first, second, third)
        self._sent.append(Ticks(self._ticks.due_ns[:passed], self._ticks.steps[:passed]))
        self._ticks = Ticks(self._ticks.due_ns[passed:], self._ticks.steps[passed:])
        self._after = self._after[passed:]
