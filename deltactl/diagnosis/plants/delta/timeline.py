"""When a job's motors are where: all step together, one tick every T_PWM (Zhao 2023)."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.delta.motions import Motion
from deltactl.diagnosis.plants.delta.options import NEXT_RUNS
from deltactl.recording.tables.flat import FlatRecording


def duration_s(motion: Motion, rad_per_step: float) -> float:
    """How long one repeat takes [s]."""
    return float(_corners(motion, rad_per_step)[0][-1])


def commanded(
    motion: Motion, rad_per_step: float, period_s: float
) -> tuple[FloatArray, FloatArray]:
    """Times (n,) [s] every `period_s` and commanded counts (n, 3) of one repeat."""
    at_s, counts = _corners(motion, rad_per_step)
    t_s = np.arange(0.0, at_s[-1] + NEXT_RUNS.readings_after_s, period_s)
    return t_s, np.stack([np.rint(np.interp(t_s, at_s, column)) for column in counts.T], axis=1)


def as_recording(
    motion: Motion, rad_per_step: float, period_s: float, channels: tuple[str, ...]
) -> FlatRecording:
    """A recording of one repeat in which nothing was read yet (all readings 0)."""
    t_s, counts = commanded(motion, rad_per_step, period_s)
    columns = {f"steps_{motor + 1}": counts[:, motor] for motor in range(3)}
    columns |= {name: np.zeros(len(t_s)) for name in channels}
    return FlatRecording(t_s, columns, {}, motion.name)


def _corners(motion: Motion, rad_per_step: float) -> tuple[FloatArray, FloatArray]:
    """Times at which moves begin and end, and the counts there."""
    counts = np.rint(motion.angles_rad / rad_per_step)
    ticks = np.abs(np.diff(counts, axis=0)).max(axis=1)
    moves_s = ticks * motion.t_pwm_s
    arrive = np.concatenate(
        [[0.0], np.cumsum(moves_s) + motion.dwell_s * np.arange(1, len(counts))]
    )
    leave = arrive + motion.dwell_s
    at_s = np.stack([arrive, leave], axis=1).ravel()
    return at_s + 1e-9 * np.arange(len(at_s)), np.repeat(counts, 2, axis=0)
