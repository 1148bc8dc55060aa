"""A motion with the steps of late drives moved ahead; all else waits as long as they need.

Where the platform rings, what is made is another motion, worked out before that.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from deltactl.drivers.steps.contract import NO_TICKS, Int64Array
from deltactl.firmware_py.compensation.lead import Lead, ahead_s, lags_s, smoothed_s
from deltactl.firmware_py.compensation.ringing import Ringing
from deltactl.firmware_py.planner.motion import NOTHING_REACHED, Chunk, Reached
from deltactl.firmware_py.planner.step_gate import StepGate
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.foundation.clock import ns

MERGE_S = 20e-6
"""Steps of different motors this near to each other are one tick."""
BETWEEN_COUNTS_S = 0.004
"""What is smooth already is smoothed by so little more."""
Made = tuple[Int64Array, Int64Array, int]
"""Times of steps of one motor, their directions, and up to when that is all."""


class LeadStream:
    """Turns the chunks of a motion into chunks `after_ns` later, late drives less so."""

    def __init__(
        self,
        robot: RobotFile,
        jump_hz: float = 0.0,
        ringing: Ringing | None = None,
        as_given: bool = False,
    ):
        """jump_hz: by so much the step rates of the motion may change at once.

        ringing: makes a smooth motion of it, which does not ring. as_given: nothing is changed.
        """
        dead_s, lag_s = lags_s(robot)
        pairs = list(zip(dead_s.tolist(), lag_s.tolist(), strict=True))
        together = robot.steps.backend == "gpiozero"
        late = any(dead + lag > 0.0 for dead, lag in pairs)
        self.active = (late or ringing is not None) and not (together or as_given)
        """The gpiozero backend cannot step motors one shortly after the other."""
        step_s = 1.0 / robot.limits.step_rate_hz
        fastest = min(
            robot.limits.step_rate_hz, robot.limits.joint_speed_radps / robot.drive.rad_per_step
        )
        acceleration = robot.limits.joint_acceleration_radps2 / robot.drive.rad_per_step
        self._ringing, least_s, reach_s = ringing, 0.0, 0.0
        if ringing is not None:
            jump_hz, least_s, reach_s = 0.0, BETWEEN_COUNTS_S, ringing.reach_s
        smoothed = [max(smoothed_s(lag, acceleration, jump_hz), least_s) for _, lag in pairs]
        ahead = [ahead_s(dead, one) for (dead, _), one in zip(pairs, smoothed, strict=True)]
        self.after_ns = ns(max(ahead) + reach_s) if self.active else 0
        self._leads = [
            Lead(dead, lag, self.after_ns, fastest, acceleration, jump_hz, least_s)
            for dead, lag in pairs
        ]
        self._gate = StepGate()
        self._gate.rules(min(ns(MERGE_S), ns(step_s / 6.0)), ns(step_s))

    def chunks(self, planned: Iterator[Chunk]) -> Iterator[Chunk]:
        """The same motion, nothing of it lost."""
        waiting: list[Reached] = []
        until_ns = 0
        for chunk in planned:
            until_ns = max(until_ns, chunk.until_ns)
            yield from self._moved(chunk, waiting)
        # The plan ends here: the arms stand, which is all that need be known.
        rest = Chunk(NO_TICKS, NOTHING_REACHED, until_ns + 3 * self.after_ns)
        yield from self._moved(rest, waiting)

    def _moved(self, chunk: Chunk, waiting: list[Reached]) -> Iterator[Chunk]:
        made = self._shaped(chunk) if self._ringing is not None else self._led(chunk)
        until_ns = min(known for _, _, known in made)
        ticks = self._gate.ticks([due for due, _, _ in made], [way for _, way, _ in made], until_ns)
        if len(chunk.reached):
            waiting.append(chunk.reached)
        settled = min(until_ns, self._gate.settled_ns)
        yield Chunk(ticks, self._reached(waiting, settled), settled)

    def _led(self, chunk: Chunk) -> list[Made]:
        made = []
        for motor, lead in enumerate(self._leads):
            mine = np.flatnonzero(chunk.ticks.steps[:, motor])
            signs = chunk.ticks.steps[mine, motor].astype(np.int64)
            made.append(lead.steps(chunk.ticks.due_ns[mine], signs, chunk.until_ns))
        return made

    def _shaped(self, chunk: Chunk) -> list[Made]:
        assert self._ringing is not None
        counts = self._ringing.counts(chunk.ticks, chunk.until_ns)
        return [lead.along(counts[:, motor]) for motor, lead in enumerate(self._leads)]

    def _reached(self, waiting: list[Reached], until_ns: int) -> Reached:
        """Targets that are due by then, moved as the whole motion is."""
        if not waiting:
            return NOTHING_REACHED
        first, *rest = waiting
        for more in rest:
            first = _joined(first, more)
        t_ns = first.t_ns + self.after_ns
        count = int(np.searchsorted(t_ns, until_ns, side="right"))
        waiting[:] = [first.part(slice(count, None))] if count < len(first) else []
        return replace(first.part(slice(None, count)), t_ns=t_ns[:count])


def _joined(one: Reached, more: Reached) -> Reached:
    return Reached(
        *(np.concatenate([getattr(one, name), getattr(more, name)]) for name in Reached.__slots__)
    )
