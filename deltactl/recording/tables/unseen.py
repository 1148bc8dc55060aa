"""The flat table of a run that no sensor saw: what was commanded, and in simulation the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from deltactl.foundation.errors import RecordingError
from deltactl.recording.reading.run import Run
from deltactl.recording.tables.flat import AnyArray, FlatRecording
from deltactl.recording.tables.rounds import AXES, flatten

_NS = 1e-9
OF_SENSORS = frozenset(f"{stem}_{axis}" for stem in ("range", "status", "t") for axis in AXES)


def has_readings(run: Run) -> bool:
    """Whether a ranging sensor gave anything."""
    return any(len(samples.t_ns) for samples in run.readings.values())


def flatten_unseen(run: Run, with_truth: bool = False) -> FlatRecording:
    """As `flatten`, without columns of sensors; a stepper's rows are those of the control loop.

    Raises RecordingError when nothing was commanded, or there is no truth to add.
    """
    if with_truth and not len(run.truth.t_ns):
        raise RecordingError(f"{run.path}: holds no simulated truth; only simulated runs do")
    if len(run.servo.t_ns):
        table = flatten(run, with_truth)
        columns = {name: values for name, values in table.columns.items() if name not in OF_SENSORS}
        extra = {name: values for name, values in table.extra.items() if name not in OF_SENSORS}
        return replace(table, columns=columns, extra=extra)
    t_ns = np.unique(run.commanded.t_ns)
    if not len(t_ns):
        raise RecordingError(f"{run.path}: nothing was commanded, and no sensor read")
    counts = run.edges.counts_at(t_ns).astype(np.float64)
    steps = {f"steps_{motor + 1}": counts[:, motor] for motor in range(counts.shape[1])}
    t_pwm_s = run.settings.t_pwm_at(t_ns)
    timed = {"t_pwm": t_pwm_s} if np.isfinite(t_pwm_s).any() else {}
    truth: dict[str, AnyArray] = {}
    if with_truth:
        named = {f"truth_{axis}_m": run.truth.position_m[:, k] for k, axis in enumerate(AXES)}
        named |= {f"truth_theta_{k + 1}_rad": run.truth.angles_rad[:, k] for k in range(3)}
        truth = {
            name: np.interp(t_ns, run.truth.t_ns, values, left=np.nan, right=np.nan)
            for name, values in named.items()
        }
    return FlatRecording(t_ns * _NS, steps | timed, truth, str(run.path))
