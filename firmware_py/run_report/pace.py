"""How far a run is along its path in the time of the plan, which stands still during a pause."""

from __future__ import annotations

import numpy as np

from deltactl.models.robot import FloatArray
from deltactl.recording.reading.columns import Int64Array
from deltactl.recording.reading.run import Run

_NS = 1e-9


def planned_s(run: Run, t_s: FloatArray) -> FloatArray:
    """Times of the plan, (n,) [s], at times of the run; the two run alike but for pauses.

    Every motion begins at the planned pace, and its settings are recorded as it begins. A recording
    of an earlier version has no paces, and its pauses are not known.
    """
    if not len(run.paces.t_ns):
        return t_s
    afresh, changes = np.ones(len(run.settings.t_ns)), run.paces
    times_s = np.concatenate([run.settings.t_ns, changes.t_ns]) * _NS
    order = np.argsort(times_s, kind="stable")
    begins_s = times_s[order]
    rate = np.concatenate([afresh, changes.rate])[order]
    goal = np.concatenate([afresh, changes.goal])[order]
    ramp_s = np.concatenate([0.0 * afresh, changes.ramp_s])[order]

    def gone_s(row: Int64Array, since_s: FloatArray) -> FloatArray:
        """Planned time that passes after a change of pace."""
        on_ramp_s = np.minimum(since_s, ramp_s[row])
        growth = (goal - rate)[row] / np.maximum(ramp_s[row], _NS)
        gone: FloatArray = on_ramp_s * (rate[row] + growth * on_ramp_s / 2.0)
        gone += goal[row] * (since_s - on_ramp_s)
        return gone

    every = np.arange(len(begins_s))
    passed_s = gone_s(every[:-1], np.diff(begins_s))
    reached_s = begins_s[0] + np.concatenate([[0.0], np.cumsum(passed_s)])
    row = np.searchsorted(begins_s, t_s, side="right") - 1
    known = np.maximum(row, 0)
    return np.where(row < 0, t_s, reached_s[known] + gone_s(known, t_s - begins_s[known]))
