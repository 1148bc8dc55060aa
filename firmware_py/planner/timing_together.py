"""Zhao 2023: all motors step together, one tick every T_PWM.

From one target to the next the motor with most steps makes one at every tick; the steps of
the others are spread evenly (Bresenham's line). There are no ramps: the speed limit is the
drives' start-stop rate, which the robot file gives as `limits.step_rate_hz`.

A pulse stands for the period around it: a target is due half a period after the last pulse
towards it. Pulses at the ends of their periods would keep arms late by half a period all along
the path, as a hold does (half a step of the fastest motor, whatever the speed).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from deltactl.drivers.steps.contract import Int8Array, Int64Array, Ticks
from deltactl.firmware_py.planner.step_gate import StepGate
from deltactl.foundation.clock import NS_PER_S, ns
from deltactl.models.robot import FloatArray

_TICKS_AT_ONCE = 4096


class TogetherSchedule:
    """Ticks between targets given as counts (n, 3), with rests dwell_s (n,) at them.

    Rests are rounded up to whole periods, so that every tick of a lap lies on one grid.
    """

    gate_ns = (0, 0)

    def __init__(self, counts: Int64Array, dwell_s: FloatArray, t_pwm_s: float):
        self._period_ns = ns(t_pwm_s)
        self._delta = np.diff(counts, axis=0)
        self._ticks = np.abs(self._delta).max(axis=1, initial=0)
        rests = np.ceil(dwell_s / t_pwm_s * (1.0 - 1e-12)).astype(np.int64)
        before = np.concatenate([[0], np.cumsum(self._ticks + rests[:-1])])
        # The rest at a target comes after it is reached, before the ticks to the next.
        self._first_tick = before[:-1] + rests[:-1]
        self.reached_ns: Int64Array = before * self._period_ns
        self.reached_ns[1:] = (self._first_tick + self._ticks) * self._period_ns
        self.left_ns: Int64Array = self.reached_ns + rests * self._period_ns
        self.duration_ns = int((before[-1] + rests[-1]) * self._period_ns)
        self.rest_ns = int(rests.sum()) * self._period_ns
        self.peak_rate_hz = _peak_rate(self._delta, self._ticks) * (NS_PER_S / self._period_ns)

    def play(self, first: int, last: int, start_ns: int, gate: StepGate) -> Iterator[Ticks]:
        ticks = np.cumsum(self._ticks[first:last])
        total = int(ticks[-1]) if len(ticks) else 0
        for begin in range(0, total, _TICKS_AT_ONCE):
            tick = np.arange(begin, min(begin + _TICKS_AT_ONCE, total))
            move = np.searchsorted(ticks, tick, side="right")
            within = tick - (ticks - self._ticks[first:last])[move]
            move += first
            due_ns = (self._first_tick[move] + within) * self._period_ns + self._period_ns // 2
            yield Ticks(start_ns + due_ns, self._steps(move, within))

    def _steps(self, move: Int64Array, within: Int64Array) -> Int8Array:
        """Steps of the ticks number `within` (from 0) of moves, (n, 3)."""
        size, ticks = np.abs(self._delta[move]), self._ticks[move][:, None]
        done = _spread(size, ticks, within[:, None])
        steps = (_spread(size, ticks, within[:, None] + 1) - done) * np.sign(self._delta[move])
        narrow: Int8Array = steps.astype(np.int8)
        return narrow


def _spread(size: Int64Array, ticks: Int64Array, after: Int64Array) -> Int64Array:
    """How many of `size` steps are made after some of the `ticks` ticks, rounded half up."""
    made: Int64Array = (2 * after * size + ticks) // (2 * ticks)
    return made


def _peak_rate(delta: Int64Array, ticks: Int64Array) -> FloatArray:
    """Steps per period where the steps of each motor are nearest to each other, (3,).

    Where n steps are spread over a move their distance is rounded down, so it is at most that.
    """
    rate = np.zeros(delta.shape[1])
    for motor, column in enumerate(np.abs(delta).T):
        moves = np.flatnonzero(column)
        if not len(moves):
            continue
        size, of = column[moves], ticks[moves]
        inside = (of // size)[size > 1]
        # From the last step of one move to the first of the next, over the moves between.
        left, ahead = of // (2 * size), -(-of // (2 * size))
        total = np.cumsum(ticks)
        between = (total - ticks)[moves[1:]] - total[moves[:-1]]
        across = left[:-1] + between + ahead[1:]
        apart = np.concatenate([inside, across])
        rate[motor] = 1.0 / (apart.min() if len(apart) else of.min())
    return rate
