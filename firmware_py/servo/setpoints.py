"""Set-points that were asked for, as a smooth reference of the arms.

A tick says that an arm's angle passes half a count at that instant (see
planner/timing_accelerated.py), so the angle is known exactly then; in between it is taken as
straight. Nothing is invented ahead of the newest set-point: there the reference stands still.
"""

from __future__ import annotations

import numpy as np

from deltactl.drivers.current_drives import JOINTS, Three
from deltactl.drivers.steps.contract import NO_TICKS, Counts, Ticks
from deltactl.models.robot import FloatArray

AHEAD = 100
"""References are worked out for so many ticks at once: an array costs little more than a number."""


class Setpoints:
    """A queue of ticks; `references_rad` walks along it."""

    def __init__(self, rad_per_step: float, period_ns: int):
        self._step_rad = rad_per_step
        self._period_ns = period_ns
        self._sent: list[Ticks] = []
        self.restart((0, 0, 0), 0)

    def restart(self, counts: Counts, now_ns: int) -> None:
        """Forget what is queued: the arms are asked to be where the counts say."""
        self.counts = counts
        self._ticks = NO_TICKS
        self._after = np.empty((0, JOINTS), dtype=np.int64)
        self._passed = 0
        self._known = [(np.array([float(now_ns)]), np.array([float(count)])) for count in counts]
        self._ready: list[list[float]] = [[], [], []]
        self._ready_ns = now_ns

    def __len__(self) -> int:
        return len(self._ticks) - self._passed

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
        passed, self._passed = self._passed, 0
        self._ticks = Ticks.joined([self._ticks.part(slice(passed, None)), ticks])
        self._after = np.concatenate([self._after[passed:], after])
        self._ready = [[], [], []]

    def references_rad(self, start_ns: int, ticks: int) -> list[list[float]]:
        """The arms' references at so many ticks of the loop: three lists.

        Calls go forwards in time; what is due by the last tick counts as passed.
        """
        self._pass(start_ns + self._period_ns * (ticks - 1))
        if self._ready_ns != start_ns or len(self._ready[0]) < ticks:
            self._make_ready(start_ns, max(ticks, AHEAD))
        found = [ready[:ticks] for ready in self._ready]
        self._ready = [ready[ticks:] for ready in self._ready]
        self._ready_ns = start_ns + self._period_ns * ticks
        return found

    def take_sent(self) -> Ticks:
        """Ticks that were passed since the last call, without those that ask for no step."""
        sent, self._sent = Ticks.joined(self._sent), []
        return sent.part((sent.steps != 0).any(axis=1))

    def references_now_rad(self) -> Three:
        """Where the counts put the arms."""
        first, second, third = self.counts
        return first * self._step_rad, second * self._step_rad, third * self._step_rad

    def _make_ready(self, start_ns: int, ticks: int) -> None:
        times_ns: FloatArray = start_ns + self._period_ns * np.arange(ticks, dtype=np.float64)
        self._ready = []
        for motor, (times, places) in enumerate(self._known):
            if len(times) == 1:
                self._ready.append([float(places[0]) * self._step_rad] * ticks)
                continue
            angles = np.interp(times_ns, times, places) * self._step_rad
            self._ready.append(angles.tolist())
            keep = int(np.searchsorted(times, start_ns, side="right")) - 1
            if keep > 0:
                self._known[motor] = (times[keep:], places[keep:])

    def _pass(self, until_ns: int) -> None:
        due_ns, before = self._ticks.due_ns, self._passed
        if before == len(due_ns) or due_ns[before] > until_ns:
            return
        self._passed = int(np.searchsorted(due_ns, until_ns, side="right"))
        first, second, third = self._after[self._passed - 1].tolist()
        self.counts = (first, second, third)
        self._sent.append(self._ticks.part(slice(before, self._passed)))
