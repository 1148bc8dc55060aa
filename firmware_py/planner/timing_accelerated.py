"""Driving a curve with limited speed and acceleration of every motor.

The whole lap is looked ahead over: the speed profile is the fastest one that comes to rest
where it must. A motor steps where its angle passes half counts, so that at each target its
count is the rounded angle, exactly as when stepping together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from deltactl.drivers.steps.contract import MOTORS, Int64Array, Ticks
from deltactl.firmware_py.job_file import FASTEST_MPS, SLOWEST_MPS
from deltactl.firmware_py.paths.path import BoolArray
from deltactl.firmware_py.planner.curve import LONGEST_STEPS, curve_through, squared_rates
from deltactl.firmware_py.planner.motion import NEVER, Schedule, StepGate
from deltactl.firmware_py.planner.timing_moves import MotorLimits
from deltactl.foundation.clock import NS_PER_S
from deltactl.foundation.errors import LimitExceeded
from deltactl.models.robot import FloatArray

_SAMPLES = int(LONGEST_STEPS)
"""Looks a piece: about one a step. The angle is taken as straight in between, which
misplaces a step by at most 1/8 of what its speed changes within one of these looks."""


class CurveSchedule:
    """Steps along a lap of targets (n, 3), with rests, at `speed_mps` where limits allow.

    speed_mps: one for all, or of the way to each target but the first, (n - 1,).
    """

    def __init__(
        self,
        angles_rad: FloatArray,
        position_m: FloatArray,
        rest: BoolArray,
        dwell_s: FloatArray,
        speed_mps: float | FloatArray,
        limits: MotorLimits,
    ):
        self._step_rad = limits.rad_per_step
        self._last_rad = angles_rad[-1:]
        hop_m = np.linalg.norm(np.diff(position_m, axis=0), axis=1)
        self._curve = curve_through(angles_rad, rest, limits.rad_per_step, hop_m)
        rests = np.zeros(len(self._curve.width) + 1, dtype=np.bool_)
        rests[self._curve.first_piece[rest]] = True
        self._rates = np.sqrt(self._squared_rates(hop_m, rests, speed_mps, limits))
        self._time(dwell_s)
        first, _ = self._curve.bounds()
        rate = np.maximum(self._rates[:-1], self._rates[1:])[:, None]
        self.peak_rate_hz: FloatArray = (first * rate).max(axis=0) / self._step_rad
        self.gate_ns = limits.gate_ns(float(self.peak_rate_hz.max()))
        self._note_fastest(hop_m, first, rate[:, 0], speed_mps)

    def _note_fastest(
        self,
        hop_m: FloatArray,
        first: FloatArray,
        rate: FloatArray,
        speed_mps: float | FloatArray,
    ) -> None:
        """The platform's highest speed, that of the arms there, and the highest asked for."""
        along_mps = (hop_m / self._curve.span)[self._curve.piece_of] * rate
        at = int(np.argmax(along_mps))
        self.top_speed_mps = float(along_mps[at])
        self.top_joint_radps = float(first[at].max() * rate[at])
        self.asked_mps = float(np.max(speed_mps))

    def angle_range_rad(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest angle of each arm anywhere on the curve, (3,)."""
        angles = self._curve.angles_rad(self._curve.piece_of, self._curve.piece_start)
        return angles.min(axis=0), angles.max(axis=0)

    def _squared_rates(
        self,
        hop_m: FloatArray,
        rests: BoolArray,
        speed_mps: float | FloatArray,
        limits: MotorLimits,
    ) -> FloatArray:
        with np.errstate(divide="ignore", over="ignore"):
            top_rate = (speed_mps / hop_m * self._curve.span)[self._curve.piece_of]
        return squared_rates(
            self._curve,
            rests,
            top_rate,
            limits.planned_speed_radps,
            limits.planned_acceleration_radps2,
        )

    def _time(self, dwell_s: FloatArray) -> None:
        piece_s = 2.0 * self._curve.width_u / (self._rates[:-1] + self._rates[1:])
        rest_s = np.zeros(len(piece_s) + 1)
        rest_s[self._curve.first_piece] = dwell_s
        done_s = np.cumsum(piece_s + rest_s[:-1])
        # When each piece begins, after the rest at its start.
        self._begins_s: FloatArray = np.concatenate([[0.0], done_s[:-1]]) + rest_s[:-1]
        ends_s = np.concatenate([[0.0], done_s])
        self.reached_ns: Int64Array = np.rint(ends_s[self._curve.first_piece] * NS_PER_S).astype(
            np.int64
        )
        self.left_ns: Int64Array = self.reached_ns + np.rint(dwell_s * NS_PER_S).astype(np.int64)
        self.rest_ns = round(float(dwell_s.sum()) * NS_PER_S)
        self.duration_ns = round((ends_s[-1] + rest_s[-1]) * NS_PER_S)

    def play(self, first: int, last: int, start_ns: int, gate: StepGate) -> Iterator[Ticks]:
        """See Schedule. One piece in all."""
        pieces = np.arange(self._curve.first_piece[first], self._curve.first_piece[last])
        if not len(pieces):
            return
        look = np.repeat(pieces, _SAMPLES)
        part = np.tile(np.arange(_SAMPLES) / _SAMPLES, len(pieces))
        angles = self._look(look, part)
        due_ns, steps = [], []
        for motor in range(MOTORS):
            at, sign, passed = _crossings(angles[:, motor], self._step_rad)
            time_s = self._at(look[at], part[at] + passed / _SAMPLES)
            due_ns.append(start_ns + np.rint(time_s * NS_PER_S).astype(np.int64))
            steps.append(sign)
        at_end = last + 1 == len(self.reached_ns)
        yield gate.ticks(due_ns, steps, NEVER if at_end else start_ns + int(self.reached_ns[last]))

    def _look(self, piece: Int64Array, part: FloatArray) -> FloatArray:
        """Angles at parts of pieces, and at the end of the last one; (k + 1, 3)."""
        curve = self._curve
        angles = curve.angles_rad(
            curve.piece_of[piece], curve.piece_start[piece] + part * curve.width[piece]
        )
        return np.concatenate([angles, self._end_of(int(piece[-1]))])

    def _end_of(self, piece: int) -> FloatArray:
        """Angles at the end of a piece that ends at a target, without rounding; (1, 3)."""
        curve = self._curve
        following = int(curve.piece_of[piece]) + 1
        if following < len(curve.start_rad):
            return curve.start_rad[following : following + 1]
        return self._last_rad

    def _at(self, piece: Int64Array, part: FloatArray) -> FloatArray:
        """Time from the lap's start at which a part of a piece is done [s]."""
        rate, end = self._rates[piece], self._rates[piece + 1]
        now = np.sqrt(rate * rate + (end * end - rate * rate) * part)
        done = rate + now
        # At the very start of a stretch both rates and the part are 0.
        with np.errstate(invalid="ignore"):
            width_u = self._curve.width[piece] * self._curve.span[self._curve.piece_of[piece]]
            since = np.where(part > 0.0, 2.0 * width_u * part / done, 0.0)
        time_s: FloatArray = self._begins_s[piece] + since
        return time_s


def _crossings(angle_rad: FloatArray, step_rad: float) -> tuple[Int64Array, Int64Array, FloatArray]:
    """Where an angle (k + 1,) passes half counts: interval, sign, and part of the interval."""
    count = np.rint(angle_rad / step_rad).astype(np.int64)
    change = np.diff(count)
    at = np.repeat(np.arange(len(change)), np.abs(change))
    sign = np.sign(change)[at]
    first = np.cumsum(np.abs(change)) - np.abs(change)
    number = np.arange(len(at)) - first[at]
    half_rad = (count[at] + sign * (number + 0.5)) * step_rad
    part = (half_rad - angle_rad[at]) / (angle_rad[at + 1] - angle_rad[at])
    return at, sign, part.clip(0.0, 1.0)


CLOSE = 1e-4
"""Share of the duration by which the path may take longer or shorter."""
MOST_HALVINGS = 40


def timed_in(duration_s: float, at_speed: Callable[[float], Schedule], mean_mps: float) -> Schedule:
    """The schedule that takes `duration_s`, rests included.

    at_speed: the schedule at a platform speed [m/s]. mean_mps: the speed that would take so long
    without ramps, or SLOWEST_MPS. Raises LimitExceeded naming the shortest time there is.
    """
    slow = min(max(mean_mps, SLOWEST_MPS), FASTEST_MPS)
    fast = FASTEST_MPS
    schedule = at_speed(fast)
    if _takes_s(schedule) > duration_s * (1.0 + CLOSE):
        least_s = math.ceil(100.0 * _takes_s(schedule)) / 100.0
        raise LimitExceeded(
            f"timing.duration_s {duration_s:g}: this path takes {least_s:g} s at the fastest that"
            f" the limits of speed and acceleration allow; give {least_s:g} or more"
        )
    for _ in range(MOST_HALVINGS):
        if abs(_takes_s(schedule) - duration_s) <= CLOSE * duration_s:
            break
        middle = math.sqrt(slow * fast)
        schedule = at_speed(middle)
        if _takes_s(schedule) > duration_s:
            slow = middle
        else:
            fast = middle
    return schedule


def _takes_s(schedule: Schedule) -> float:
    return schedule.duration_ns / NS_PER_S
