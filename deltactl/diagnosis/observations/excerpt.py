"""An excerpt of a recording too long to be worked on: whole stretches, spread over all of it.

Stretches keep what lives between one row and the next (play, lag, the memory of the noise); every
so many rows would not. Each is the one in its part of the recording in which most moves.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.recording.tables.flat import GAP_PERIODS, FlatRecording

APART = int(GAP_PERIODS) + 1
"""Rows between two stretches, so that each is one."""
MOVES = ("steps_", "command", "theta_", "position", "distance")


def excerpt(recording: FlatRecording, most: int, every: int = 1) -> FlatRecording:
    """The recording itself, or stretches of it with `most` rows together; every: so many rows."""
    rows = recording.rows(slice(None, None, every)) if every > 1 else recording
    if len(rows) <= most:
        return rows
    kept = rows.rows(_chosen(rows, most))
    return replace(kept, taken_from=recording.taken_from or len(recording))


def _chosen(recording: FlatRecording, most: int) -> IntArray:
    """Rows of the stretches, with a gap between each and the next."""
    count, length = len(recording), most // OBSERVATIONS.stretches
    moved = np.concatenate([[0.0], np.cumsum(_moving(recording))])
    edges = np.linspace(0, count, OBSERVATIONS.stretches + 1).astype(int)
    found = []
    for begin, end in itertools.pairwise(edges.tolist()):
        first = np.arange(begin, max(begin + 1, end - length - APART))
        best = int(first[np.argmax(moved[first + length - 1] - moved[first])])
        found.append(np.arange(best, min(best + length, count)))
    rows: IntArray = np.unique(np.concatenate(found))
    return rows


def _moving(recording: FlatRecording) -> FloatArray:
    """How much moves from each row to the next, (n - 1,), each column in its own measure."""
    total = np.zeros(len(recording) - 1)
    for name, values in recording.columns.items():
        if name.startswith(MOVES):
            step = np.abs(np.nan_to_num(np.diff(values)))
            # Not the size: a reading that leaps would draw all stretches to it.
            total += step > 0.0
    return total
