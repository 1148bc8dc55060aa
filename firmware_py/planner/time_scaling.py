"""Pausing on the path: the motion's own time runs slower and slower until it stops.

Motion time is what the plan's chunks are in, run time is what passes outside (both from the
motion's start). The rate between them is 1 while running, falls or rises evenly while
slowing down or speeding up, and is 0 while held: so the arms stay on the path.
"""

from __future__ import annotations

import enum
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from deltactl.drivers.steps.contract import NO_TICKS, Int64Array, Ticks
from deltactl.firmware_py.planner.motion import NOTHING_REACHED, Chunk, Reached
from deltactl.foundation.clock import ns

_NEVER = np.iinfo(np.int64).max

_PACES = 8
"""Changes of pace remembered: what runs now may be some changes behind what was taken."""


@dataclass(frozen=True, slots=True)
class Pace:
    """From run time `run_ns` on the rate goes evenly from `rate` to `goal`, then stays there."""

    run_ns: int
    motion_ns: int
    rate: float
    goal: float
    ramp_ns: int

    @property
    def slope(self) -> float:
        """Change of the rate per ns; 0 when there is no ramp."""
        return (self.goal - self.rate) / self.ramp_ns if self.ramp_ns else 0.0

    @property
    def steady_run_ns(self) -> int:
        """Run time from which the rate is `goal`."""
        return self.run_ns + self.ramp_ns

    @property
    def steady_motion_ns(self) -> int:
        """Motion time then."""
        return self.motion_ns + round((self.rate + self.goal) / 2.0 * self.ramp_ns)

    def rate_at(self, run_ns: int) -> float:
        """Motion time per run time."""
        if run_ns >= self.steady_run_ns:
            return self.goal
        return self.rate + self.slope * (run_ns - self.run_ns)

    def motion_at(self, run_ns: int) -> int:
        """Motion time at a run time not before this pace began."""
        if run_ns >= self.steady_run_ns:
            # The rate is 1 or 0 there: whole nanoseconds, nothing is lost over days.
            return self.steady_motion_ns + round(self.goal) * (run_ns - self.steady_run_ns)
        since = run_ns - self.run_ns
        return self.motion_ns + int(since * (self.rate + self.slope * since / 2.0))

    def run_at(self, motion_ns: Int64Array) -> Int64Array:
        """Run times at which motion times are due; the largest integer for never."""
        if self.goal and not self.ramp_ns:  # at full speed, as nearly always: only a shift
            return self.run_ns + np.maximum(motion_ns - self.motion_ns, 0)
        ahead = (motion_ns - self.motion_ns).astype(np.float64)
        root = np.sqrt(np.maximum(self.rate**2 + 2.0 * self.slope * ahead, 0.0)) + self.rate
        with np.errstate(divide="ignore", invalid="ignore"):
            since = np.where(ahead > 0.0, 2.0 * ahead / root, 0.0)
        on_ramp = self.run_ns + np.rint(np.minimum(since, self.ramp_ns)).astype(np.int64)
        steady = motion_ns - self.steady_motion_ns
        later = self.steady_run_ns + steady if self.goal else np.full_like(motion_ns, _NEVER)
        run_ns: Int64Array = np.where(steady > 0, later, on_ramp)
        return run_ns


class Pacing(enum.Enum):
    """What a warped motion is doing."""

    RUNNING = "running"
    SLOWING = "slowing"
    HELD = "held"
    DONE = "done"


class TimeScaledMotion:
    """Hands out a motion in run time, and can pause it, resume it and cancel it on the path.

    `ramp_s` is the time from full speed to standstill (`Plan.ramp_s` is the shortest that
    keeps to the acceleration limits). What was taken cannot be called back: a change of
    pace begins at the run time asked for, or where the last `take` ended if that is later.
    """

    def __init__(self, chunks: Iterator[Chunk], ramp_s: float):
        self._chunks = chunks
        self._ramp_ns = ns(ramp_s)
        self._pace = Pace(0, 0, 1.0, 1.0, 0)
        self._earlier: deque[Pace] = deque(maxlen=_PACES)
        self._taken_ns = 0
        self._ready: list[Chunk] = []
        self._rest: Chunk | None = None
        self._cancelled = False
        self._exhausted = False

    @property
    def cancelled(self) -> bool:
        """Whether the motion was cut short."""
        return self._cancelled

    def pacing(self) -> Pacing:
        """What the motion does at the end of what was taken."""
        held = self._pace.goal == 0.0 and self._taken_ns >= self._pace.steady_run_ns
        over = self._exhausted and self._rest is None
        if (over or (held and self._cancelled)) and not self._ready:
            return Pacing.DONE
        if held:
            return Pacing.HELD
        return Pacing.SLOWING if self._pace.goal == 0.0 else Pacing.RUNNING

    def motion_ns(self, run_ns: int) -> int:
        """Motion time at a run time (not further back than the last few changes of pace)."""
        for pace in (self._pace, *self._earlier):
            if run_ns >= pace.run_ns:
                break
        return pace.motion_at(run_ns)

    def pause(self, run_ns: int) -> Pace:
        """Begin to slow down. This and the two below return the pace that holds from there on."""
        return self._change(run_ns, goal=0.0)

    def resume(self, run_ns: int) -> Pace:
        """Begin to go on, also in the middle of slowing down; does nothing once cancelled."""
        return self._pace if self._cancelled else self._change(run_ns, goal=1.0)

    def cancel(self, run_ns: int) -> Pace:
        """Slow down and drop the rest."""
        self._cancelled = True
        return self._change(run_ns, goal=0.0)

    def take(self, until_ns: int) -> Chunk:
        """Everything due after the last `take` and up to run time `until_ns`.

        Raises MotionError when the motion finds that it must not go on.
        """
        until_ns = max(until_ns, self._taken_ns)
        taken = [self._warped(chunk) for chunk in self._due(self._pace.motion_at(until_ns))]
        self._taken_ns = until_ns
        taken, self._ready = self._ready + taken, []
        return _joined(taken, until_ns)

    def _due(self, motion_ns: int) -> Iterator[Chunk]:
        while True:
            if self._rest is None:
                self._rest = next(self._chunks, None)
            if self._rest is None:
                self._exhausted = True
                return
            if self._rest.until_ns > motion_ns:
                before, self._rest = self._rest.split(motion_ns)
                yield before
                return
            whole, self._rest = self._rest, None
            yield whole

    def _warped(self, chunk: Chunk) -> Chunk:
        until = np.array([chunk.until_ns])
        return chunk.at(
            self._pace.run_at(chunk.ticks.due_ns),
            self._pace.run_at(chunk.reached.t_ns),
            int(self._pace.run_at(until)[0]),
        )

    def _change(self, run_ns: int, goal: float) -> Pace:
        run_ns = max(run_ns, self._taken_ns)
        # What is due before keeps the pace that holds now.
        self._ready = [self.take(run_ns)]
        rate = self._pace.rate_at(run_ns)
        motion_ns = self._pace.motion_at(run_ns)
        self._earlier.appendleft(self._pace)
        self._pace = Pace(run_ns, motion_ns, rate, goal, round(self._ramp_ns * abs(goal - rate)))
        return self._pace


def _joined(chunks: list[Chunk], until_ns: int) -> Chunk:
    chunks = [chunk for chunk in chunks if len(chunk.ticks) or len(chunk.reached)]
    if not chunks:
        return Chunk(NO_TICKS, NOTHING_REACHED, until_ns)
    ticks = Ticks.joined([chunk.ticks for chunk in chunks])
    return Chunk(ticks, Reached.joined([chunk.reached for chunk in chunks]), until_ns)
