"""Moves straight in joint space, from rest to rest, each as fast as its limits allow.

All arms start and stop together: the part s of a move grows from 0 to 1 with constant
acceleration, constant speed and constant deceleration, set by whichever arm is nearest to
its limit. Everything is in closed form, so a survey of 100 000 moves is timed at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, Int64Array, Ticks
from deltactl.firmware_py.planner.step_gate import StepGate
from deltactl.foundation.clock import NS_PER_S
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
