"""Rows at the beginning of a stretch that its commands do not foretell.

In: times, commands, and where stretches begin. Out: which rows to leave out. A drive that follows
late is, where a recording begins within a motion, somewhere behind its command, and nobody knows
how far: a model that begins at the command, or as if it had moved on for long, is wrong there, and
a fit would pay for it with its time constants.
"""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray


def begun_in_motion(t_s: FloatArray, commanded: FloatArray, fresh: BoolArray) -> BoolArray:
    """Rows (n,) within the time that a drive settles in, of stretches that begin in motion.

    commanded: (n, m). None where the rows are further apart than that, or where it would be much
    of the recording.
    """
    none = np.zeros(len(t_s), dtype=np.bool_)
    starts = np.flatnonzero(fresh)
    steps_s = np.diff(t_s)
    if len(t_s) < 2 or float(np.median(steps_s)) > OBSERVATIONS.settles_s:
        return none
    speeds = np.abs(np.diff(commanded, axis=0)) / np.maximum(steps_s, 1e-9)[:, None]
    speeds[starts[1:] - 1] = 0.0  # from one stretch to the next nothing moved
    top = np.quantile(speeds, OBSERVATIONS.top_speed_quantile, axis=0)
    moves = (speeds > OBSERVATIONS.begins_moving * np.maximum(top, 1e-300)).any(axis=1)
    which = np.cumsum(fresh) - 1
    in_motion = np.append(moves, False)[starts][which]
    early = t_s - t_s[starts][which] < OBSERVATIONS.settles_s
    left_out: BoolArray = in_motion & early
    return left_out if float(left_out.mean()) < OBSERVATIONS.most_begun else none
