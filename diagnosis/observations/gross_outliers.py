"""Single readings so far off that they are no measurement are emptied before anything sees them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import median_filter

from diagnosis.observations.readings import BoolArray, FloatArray
from recording.tables.flat import FlatRecording

NEIGHBOURS = 7
GROSS = 30.0
"""Times the largest usual distance (nine in ten are nearer) from the neighbours' median."""
SHARE_OF_TRAVEL = 0.25
"""A reading is not gross that lies nearer to its neighbours than this share of the travel."""
MOST_OUTLIERS = 0.05
"""Where more readings than this are off, they are how the machine moves."""


def without_gross(recording: FlatRecording, names: Sequence[str]) -> FlatRecording:
    """The recording with gross outliers of these columns empty; itself where there are none."""
    emptied = {}
    for name in names:
        values = recording.columns.get(name)
        if values is not None and (gross := gross_outliers(values)).any():
            emptied[name] = np.where(gross, np.nan, values)
    if not emptied:
        return recording
    columns = {**recording.columns, **emptied}
    return FlatRecording(recording.t_s, columns, recording.extra, recording.source)


def gross_outliers(values: FloatArray) -> BoolArray:
    """Which readings (n,) stand out of their neighbours by more than any motion does."""
    gross = np.zeros(len(values), dtype=bool)
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 2 * NEIGHBOURS:
        return gross
    seen = values[known]
    off = np.abs(seen - median_filter(seen, NEIGHBOURS, mode="nearest"))
    (low, high), usual = np.quantile(seen, [0.02, 0.98]), float(np.quantile(off, 0.9))
    least = max(GROSS * usual, SHARE_OF_TRAVEL * float(high - low))
    found = (off > least) & (least > 0.0)
    if 0.0 < float(found.mean()) < MOST_OUTLIERS:
        gross[known[found]] = True
    return gross
