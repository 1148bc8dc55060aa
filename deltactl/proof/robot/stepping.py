"""Step counts over time: every T_PWM all motors that are not there yet take one step together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.proof.robot.as_built import FloatArray

IntArray = np.ndarray[Any, np.dtype[np.int64]]


@dataclass(frozen=True)
class StepTrain:
    """counts[k] (3,) is the count from `k * t_pwm_s` on; shape (n, 3)."""

    t_pwm_s: float
    counts: IntArray

    @property
    def seconds(self) -> float:
        """How long the motion lasts."""
        return len(self.counts) * self.t_pwm_s

    def at(self, t_s: FloatArray) -> IntArray:
        """Commanded counts at given times, shape (n, 3)."""
        tick = np.floor(t_s / self.t_pwm_s + 1e-9).astype(int)
        counts: IntArray = self.counts[np.clip(tick, 0, len(self.counts) - 1)]
        return counts

    def smooth(self, t_s: FloatArray) -> FloatArray:
        """Counts as a rotor turns: the staircase averaged over one step period, no lag; (n, 3)."""
        ticks_s = np.arange(len(self.counts)) * self.t_pwm_s
        before = np.vstack([self.counts[:1], self.counts[:-1]])
        middle = 0.5 * (before + self.counts)
        return np.stack([np.interp(t_s, ticks_s, middle[:, m]) for m in range(3)], axis=1)


def together(start: IntArray, targets: IntArray, dwell_s: FloatArray, t_pwm_s: float) -> StepTrain:
    """Visit the targets (n, 3) one after another, waiting `dwell_s` (n,) at each."""
    pieces = [start[None, :]]
    here = start
    for target, dwell in zip(targets, dwell_s, strict=True):
        left = target - here
        ticks = np.arange(1, int(np.abs(left).max()) + 1)[:, None]
        pieces.append(here + np.sign(left) * np.minimum(ticks, np.abs(left)))
        pieces.append(np.repeat(target[None, :], round(dwell / t_pwm_s), axis=0))
        here = target
    return StepTrain(t_pwm_s, np.concatenate(pieces))


def cut(train: StepTrain, seconds: float) -> StepTrain:
    """The first seconds of a motion."""
    return StepTrain(train.t_pwm_s, train.counts[: max(2, round(seconds / train.t_pwm_s))])
