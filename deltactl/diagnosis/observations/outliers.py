"""Rows that are no measurement of the motion: gross outliers, and the beginning of a stretch that
its commands do not foretell.

A drive that follows late is, where a recording begins within a motion, somewhere behind its
command, and nobody knows how far: a model that begins at the command, or as if it had moved on for
long, is wrong there, and a fit would pay for it with its time constants.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.recording.column_measures import TRAVEL
from deltactl.recording.tables.flat import FlatRecording


def without_gross(recording: FlatRecording, names: Sequence[str]) -> FlatRecording:
    """The recording with gross outliers of these columns empty; itself where there are none."""
    emptied = {}
    for name in names:
        values = recording.columns.get(name)
        if values is not None and (gross := gross_outliers(values)).any():
            emptied[name] = np.where(gross, np.nan, values)
    if not emptied:
        return recording
    return replace(recording, columns={**recording.columns, **emptied})


def gross_outliers(values: FloatArray) -> BoolArray:
    """Which readings (n,) differ from their neighbours by more than any motion does."""
    gross = np.zeros(len(values), dtype=bool)
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 2 * OBSERVATIONS.neighbours:
        return gross
    seen = values[known]
    off = np.abs(seen - median_filter(seen, OBSERVATIONS.neighbours, mode="nearest"))
    low, high = np.quantile(seen, TRAVEL)
    usual = float(np.quantile(off, OBSERVATIONS.gross_quantile))
    least = max(OBSERVATIONS.gross_factor * usual, OBSERVATIONS.gross_share * float(high - low))
    found = (off > least) & (least > 0.0)
    if 0.0 < float(found.mean()) < OBSERVATIONS.most_gross_share:
        gross[known[found]] = True
    gross[known[_spikes(seen)]] = True
    return gross


def _spikes(seen: FloatArray) -> BoolArray:
    """Single readings (n,) beyond both neighbours by far more than any of the others is.

    However fast a machine moves or turns back, it does so at more than a few rows.
    """
    before, after = seen[:-2], seen[2:]
    beyond = np.maximum(seen[1:-1] - np.maximum(before, after), 0.0)
    beyond += np.maximum(np.minimum(before, after) - seen[1:-1], 0.0)
    most = max(1, int(OBSERVATIONS.most_spikes * len(seen)))
    sizes = np.sort(beyond)[::-1][: most + 1]
    stands = sizes[:-1] > OBSERVATIONS.spike_factor * np.maximum(sizes[1:], 1e-300)
    spikes = np.zeros(len(seen), dtype=np.bool_)
    if stands.any() and sizes[0] > OBSERVATIONS.spike_of_travel * float(np.ptp(seen)):
        spikes[1:-1] = beyond >= sizes[int(np.flatnonzero(stands)[-1])]
    return spikes


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
    moves = (speeds > OBSERVATIONS.moving_share * np.maximum(top, 1e-300)).any(axis=1)
    which = np.cumsum(fresh) - 1
    in_motion = np.append(moves, False)[starts][which]
    early = t_s - t_s[starts][which] < OBSERVATIONS.settles_s
    left_out: BoolArray = in_motion & early
    return left_out if float(left_out.mean()) < OBSERVATIONS.most_begun else none
