"""Open-loop tracking of a curve on the as-built robot, simulated in time by MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from deltactl.models.robot import FloatArray, Sensors
from deltactl.models.training.dataset import IntArray
from deltactl.proof.recorded import Machine, sample_times
from deltactl.proof.robot.run import run
from deltactl.proof.robot.stepping import together
from deltactl.proof.sensors.ranging import read

BoolArray = np.ndarray[Any, np.dtype[np.bool_]]
JUMP_M = 0.015
"""A reading this far from the median of its neighbours is dropped, as the driver's gate does."""
NEIGHBOURS = 5
REST_S = 0.1


@dataclass(frozen=True)
class Track:
    """One run. true_m: where the platform was when each target was reached, (n, 3).

    seen_s, seen_m, seen_target_m: readings at 50 Hz that passed, and the target then, (k, 3); NaN
    where a sensor gave nothing. counts: (k, 3), commanded at these times.
    """

    target_m: FloatArray
    t_s: FloatArray
    true_m: FloatArray
    seen_s: FloatArray
    seen_m: FloatArray
    seen_target_m: FloatArray
    seen_counts: IntArray
    length_m: float
    seconds: float

    @property
    def true_error_m(self) -> FloatArray:
        """(n, 3)."""
        return self.true_m - self.target_m

    @property
    def seen_error_m(self) -> FloatArray:
        """(k, 3), NaN where nothing was seen."""
        return self.seen_m - self.seen_target_m


def follow(
    machine: Machine,
    sensors: Sensors,
    target_m: FloatArray,
    counts: IntArray,
    t_pwm_s: float,
    rng: np.random.Generator,
) -> Track:
    """Send counts (n, 3) for targets (n, 3), all motors stepping together every T_PWM.

    Raises UnreachablePoint when the robot cannot take a pose.
    """
    dwell_s = np.zeros(len(counts))
    dwell_s[-1] = REST_S
    train = together(counts[0], counts, dwell_s, t_pwm_s)
    ticks = np.cumsum(np.abs(np.diff(counts, axis=0, prepend=counts[:1])).max(axis=1))
    reached_s = ticks * t_pwm_s
    truth = run(machine.robot, train)
    true_m = at_times(truth.t_s, truth.position_m, reached_s)
    t_s = sample_times(train)
    t_s = t_s[t_s <= reached_s[-1]]
    ranges_m, status = read(machine.sensors, machine.noise, truth, t_s, rng)
    ranges_m = np.where(good(ranges_m, status), ranges_m, np.nan)
    return Track(
        target_m=target_m,
        t_s=reached_s,
        true_m=true_m,
        seen_s=t_s,
        seen_m=np.linalg.solve(sensors.axes, (ranges_m - sensors.offsets_m).T).T,
        seen_target_m=at_times(reached_s, target_m, t_s),
        seen_counts=train.at(t_s),
        length_m=float(np.linalg.norm(np.diff(target_m, axis=0), axis=1).sum()),
        seconds=float(reached_s[-1]),
    )


def at_times(known_s: FloatArray, values: FloatArray, t_s: FloatArray) -> FloatArray:
    """Columns of values (n, k) known at times (n,), at others."""
    columns = [np.interp(t_s, known_s, column) for column in values.T]
    return np.stack(columns, axis=1)


def good(ranges_m: FloatArray, status: IntArray) -> BoolArray:
    """Readings that a driver's gate would let pass, (n, 3)."""
    half = NEIGHBOURS // 2
    valid = np.where(status == 0, ranges_m, np.nan)
    padded = np.pad(valid, ((half, half), (0, 0)), mode="edge")
    around = np.stack([padded[k : k + len(valid)] for k in range(NEIGHBOURS)])
    # A window without any valid reading judges nothing: NaN compares as false.
    good: BoolArray = np.abs(valid - _median(around)) <= JUMP_M
    return good


def _median(around: FloatArray) -> FloatArray:
    """Median over the first axis without NaN; NaN where there is nothing else."""
    ordered = np.sort(around, axis=0)
    count = np.isfinite(around).sum(axis=0)
    middle: FloatArray = np.take_along_axis(ordered, (np.maximum(count, 1) - 1)[None] // 2, axis=0)
    first: FloatArray = middle[0]
    return first
