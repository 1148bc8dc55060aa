"""Timing without looking ahead: moves with ramps from rest to rest, or all motors together.

Moves straight in joint space: all arms start and stop together, the part s of a move grows from 0
to 1 with constant acceleration, constant speed and constant deceleration, set by whichever arm is
nearest to its limit. Everything is in closed form, so a survey of 100 000 moves is timed at once.

All together (Zhao 2023): one tick every T_PWM. From one target to the next the motor with most
steps makes one at every tick; the steps of the others are spread evenly (Bresenham's line). There
are no ramps: the speed limit is the drives' start-stop rate, which the robot file gives as
`limits.step_rate_hz`. A pulse represents the period around it: a target is due half a period after
the last pulse towards it. Pulses at the ends of their periods would keep arms late by half a period
all along the path, as a hold does (half a step of the fastest motor, whatever the speed).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, Int8Array, Int64Array, Ticks
from deltactl.firmware_py.planner.motion import StepGate
from deltactl.foundation.clock import NS_PER_S, ns
from deltactl.models.robot import FloatArray

MERGE_S = 50e-6
"""Steps of different motors nearer than this become one tick (or a fifth of a step period, if the
step output can tell ticks so near apart)."""

MERGE_PART = 0.2

STILL_RAD = 1e-12
"""Less than this is rounding, not movement."""

ACCELERATION_PART = 0.8
"""Plans use this part of the acceleration limit; pausing on the path needs the rest."""


@dataclass(frozen=True, slots=True)
class MotorLimits:
    """What every motor must keep to."""

    speed_radps: float
    acceleration_radps2: float
    step_rate_hz: float
    rad_per_step: float
    tick_s: float = 0.0
    """The step output cannot tell two ticks apart that are nearer than this."""

    @property
    def planned_speed_radps(self) -> float:
        """Joint speed at which merging ticks leaves the steps within the step-rate limit."""
        merged_hz = 1.0 / (1.0 / self.step_rate_hz + self.tick_s)
        rate_hz = min((1.0 - MERGE_PART) * self.step_rate_hz, merged_hz)
        return min(self.speed_radps, rate_hz * self.rad_per_step)

    @property
    def planned_acceleration_radps2(self) -> float:
        """Acceleration that leaves room for pausing."""
        return ACCELERATION_PART * self.acceleration_radps2

    def gate_ns(self, peak_rate_hz: float) -> tuple[int, int]:
        """Merge window and gap of one motor for a `StepGate`."""
        planned_s = 1.0 / max(peak_rate_hz, 1.0)
        window_s = max(min(MERGE_S, MERGE_PART * planned_s), self.tick_s)
        # Merging takes up to a window from it; it is below the planned distance of steps.
        gap_s = max(1.0 / self.step_rate_hz + window_s, min(window_s / MERGE_PART, planned_s))
        return int(window_s * NS_PER_S), int(gap_s * NS_PER_S)


class MoveSchedule:
    """Steps along moves through arm angles (n, 3) with rests dwell_s (n,) at them.

    `fastest` (n - 1,) limits the rate of each move (parts a second), for a platform speed.
    """

    def __init__(
        self,
        angles_rad: FloatArray,
        dwell_s: FloatArray,
        limits: MotorLimits,
        fastest: FloatArray | None = None,
    ):
        self._step_rad = limits.rad_per_step
        self._angles_rad = angles_rad
        self._counts = np.rint(angles_rad / self._step_rad).astype(np.int64)
        turn = np.abs(np.diff(angles_rad, axis=0))
        turn[turn < STILL_RAD] = 0.0
        with np.errstate(divide="ignore"):
            rate = (limits.planned_speed_radps / turn).min(axis=1)
            growth = (limits.planned_acceleration_radps2 / turn).min(axis=1)
        if fastest is not None:
            rate = np.minimum(rate, fastest)
        moves = turn.max(axis=1, initial=0.0) > 0.0
        self._growth = np.where(moves, growth, 1.0)
        self._rate = np.where(moves, np.minimum(rate, np.sqrt(self._growth)), 1.0)
        move_s = np.where(moves, 1.0 / self._rate + self._rate / self._growth, 0.0)
        self._time(move_s, dwell_s)
        self.peak_rate_hz: FloatArray = (turn * (moves * self._rate)[:, None]).max(
            axis=0, initial=0.0
        ) / self._step_rad
        self.gate_ns = limits.gate_ns(float(self.peak_rate_hz.max()))

    def _time(self, move_s: FloatArray, dwell_s: FloatArray) -> None:
        move_ns = np.rint(move_s * NS_PER_S).astype(np.int64)
        dwell_ns = np.rint(dwell_s * NS_PER_S).astype(np.int64)
        reached = np.concatenate([[0], np.cumsum(dwell_ns[:-1] + move_ns)])
        self.reached_ns: Int64Array = reached
        self.left_ns: Int64Array = reached + dwell_ns
        self.duration_ns = int(self.left_ns[-1])
        self.rest_ns = int(dwell_ns.sum())

    def play(self, first: int, last: int, start_ns: int, gate: StepGate) -> Iterator[Ticks]:
        """See Schedule. One piece a move."""
        for move in range(first, last):
            begin_ns = start_ns + int(self.left_ns[move])
            due_ns, steps = [], []
            for motor in range(MOTORS):
                part, sign = self._crossings(move, motor)
                due_ns.append(begin_ns + np.rint(self._at(move, part) * NS_PER_S).astype(np.int64))
                steps.append(sign)
            yield gate.ticks(due_ns, steps)

    def _crossings(self, move: int, motor: int) -> tuple[FloatArray, Int64Array]:
        """Parts of the move at which the motor's angle passes half counts, and the signs."""
        start, end = self._counts[move : move + 2, motor]
        sign = int(np.sign(end - start))
        number = np.arange(abs(end - start))
        from_rad, to_rad = self._angles_rad[move : move + 2, motor]
        passed_rad = (start + sign * (number + 0.5)) * self._step_rad
        part = (passed_rad - from_rad) / (to_rad - from_rad) if len(number) else number * 1.0
        return part.clip(0.0, 1.0), np.full(len(number), sign)

    def _at(self, move: int, part: FloatArray) -> FloatArray:
        """Time from the start of a move until a part of it is done [s]."""
        rate, growth = self._rate[move], self._growth[move]
        ramp = rate * rate / (2.0 * growth)
        end_s = 1.0 / rate + rate / growth
        speeding = np.sqrt(2.0 * part / growth)
        steady = rate / growth + (part - ramp) / rate
        slowing = end_s - np.sqrt(2.0 * (1.0 - part) / growth)
        time_s: FloatArray = np.where(
            part < ramp, speeding, np.where(part > 1.0 - ramp, slowing, steady)
        )
        return time_s


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
