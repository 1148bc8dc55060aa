"""Measures of one column: whether it holds anything, its travel, the step of its encoder."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.recording.reading.run import FloatArray
from deltactl.recording.tables.flat import FlatRecording

TRAVEL = (0.02, 0.98)
"""Quantiles between which a column's travel is read: a few wild readings do not stretch it."""
NEAR_STEP = 0.1
"""Share of a step: a reading so near to a whole multiple counts as one. One in five random numbers
does."""
MOST_ON_STEP = 0.95
"""Share of the readings that must be multiples for the step to be that of an encoder."""
SAME_STEP = 1.5
"""Times the smallest distance between readings up to which distances are one and the same step: two
steps would be twice as much."""


def first_of(recording: FlatRecording, names: Sequence[str]) -> str | None:
    """The first of the columns that holds anything."""
    for name in names:
        if name in recording.columns and bool(np.isfinite(recording.columns[name]).any()):
            return name
    return None


def travel(values: FloatArray) -> float:
    """How far a column (n,) moves, but for a few wild readings."""
    low, high = TRAVEL
    return float(np.nanquantile(values, high) - np.nanquantile(values, low))


def step_of(values: FloatArray) -> float:
    """Step [unit of the values] that all readings (n,) are whole multiples of; 0 for none.

    The smallest distance between two readings is one only if all others are multiples of it: an
    axis that turns steadily has no two readings near each other either. Nor is it one if every
    reading is one further than the last: that is the way between two samples at one speed.
    """
    known = values[np.isfinite(values)]
    if len(known) < 2:
        return 0.0
    places = np.unique(known)
    same = 1e-9 * max(float(np.abs(known).max()), 1e-300)
    places = places[np.diff(places, prepend=-np.inf) > same]
    if len(places) < 2:
        return 0.0
    step = spacing(places)
    counts = (known - known[0]) / step
    one_further = np.round(np.diff(counts)) == np.sign(counts[-1])
    if float(np.mean(one_further)) > MOST_ON_STEP:
        return 0.0
    whole = np.abs(counts - np.round(counts)) < NEAR_STEP
    return step if float(np.mean(whole)) > MOST_ON_STEP else 0.0


def spacing(places: FloatArray) -> float:
    """Step between places (k,) that rise evenly, by all of them: a log may leave decimals out."""
    apart = np.diff(places)
    near = float(np.median(apart[apart < SAME_STEP * apart.min()]))
    number = np.concatenate([[0.0], np.cumsum(np.round(apart / near))])
    even = number - number.mean()
    return float(even @ (places - places.mean()) / (even @ even))
