"""Steps of three motors, each with its own time, become ticks that can be played.

Two rules: a motor's steps keep a gap (only a motor that turns round within it is held
back), and steps of different motors that fall within the merge window become one tick at
the time of the first, because two pulses a few microseconds apart cannot be told in time to
any output. With a gap of at least five windows a tick never holds two steps of one motor,
and no step moves by more than a window.
"""

from __future__ import annotations

import numpy as np

from drivers.steps.contract import MOTORS, Int64Array, Ticks
from firmware_py.planner.motion import NO_TICKS

_LONG_AGO = -(2**62)


class StepGate:
    """Remembers the last steps, so that the rules hold from one call to the next as well."""

    def __init__(self) -> None:
        self._merge_ns = 0
        self._gap_ns = 0
        self._last_ns = [_LONG_AGO] * MOTORS
        self._last_tick_ns = _LONG_AGO

    def rules(self, merge_ns: int, gap_ns: int) -> None:
        """Merge window and gap of one motor from here on (`Schedule.gate_ns`)."""
        self._merge_ns = merge_ns
        self._gap_ns = gap_ns

    def ticks(self, due_ns: list[Int64Array], steps: list[Int64Array]) -> Ticks:
        """Ticks of each motor's step times (non-decreasing) and signs, motor by motor."""
        held = [self._keep_gap(motor, times) for motor, times in enumerate(due_ns)]
        t_ns = np.concatenate(held)
        if not len(t_ns):
            return NO_TICKS
        order = np.argsort(t_ns, kind="stable")
        t_ns = t_ns[order]
        motor = np.repeat(np.arange(MOTORS), [len(times) for times in held])[order]
        starts = _group_starts(t_ns, self._merge_ns)
        tick = np.cumsum(starts) - 1
        out = np.zeros((int(tick[-1]) + 1, MOTORS), dtype=np.int8)
        out[tick, motor] = np.concatenate(steps)[order]
        return Ticks(self._space_ticks(t_ns[starts]), out)

    def _keep_gap(self, motor: int, t_ns: Int64Array) -> Int64Array:
        if not len(t_ns):
            return t_ns
        # t'[k] = max(t[k], t'[k-1] + gap), as a running maximum.
        ramp = np.arange(len(t_ns)) * self._gap_ns
        first = max(int(t_ns[0]), self._last_ns[motor] + self._gap_ns)
        slack = t_ns - ramp
        slack[0] = first
        kept: Int64Array = np.maximum.accumulate(slack) + ramp
        self._last_ns[motor] = int(kept[-1])
        return kept

    def _space_ticks(self, t_ns: Int64Array) -> Int64Array:
        """Ticks at least a window (and 1 ns) apart, also from those of the call before."""
        apart = max(1, self._merge_ns)
        ramp = np.arange(len(t_ns)) * apart
        slack = t_ns - ramp
        slack[0] = max(int(slack[0]), self._last_tick_ns + apart)
        spaced: Int64Array = np.maximum.accumulate(slack) + ramp
        self._last_tick_ns = int(spaced[-1])
        return spaced


def _group_starts(t_ns: Int64Array, merge_ns: int) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which of the sorted times begin a tick: those not within the window of one that does.

    Among four steps one motor has two, a gap of five windows apart: no group of more than three.
    """
    starts = np.ones(len(t_ns), dtype=np.bool_)
    near = np.diff(t_ns) < max(1, merge_ns)
    starts[1:] = ~near
    # The third of three in a row may lie beyond the window of the first.
    third = np.flatnonzero(near[1:] & near[:-1]) + 2
    beyond = t_ns[third] - t_ns[third - 2] >= max(1, merge_ns)
    starts[third[beyond]] = True
    return starts
