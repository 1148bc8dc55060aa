"""An excerpt of a recording too long to be worked on: whole stretches, spread over all of it.

Stretches keep what lives between one row and the next (play, lag, the memory of the noise); every
so many rows would not. Each is the one in its part of the recording in which most moves.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from deltactl.recording.reading.run import FloatArray
from deltactl.recording.tables.cells import IntArray
from deltactl.recording.tables.flat import GAP_PERIODS, FlatRecording

STRETCHES = 10
"""One in each tenth: what changes over hours shows in their order."""
LED_IN = 0.2
"""Share of a stretch's rows that come before it, for the moves that lead to it."""
LEAD_EVERY = int(GAP_PERIODS) // 2
"""Every so many rows lead to a stretch: half of what would be a gap."""
APART = int(GAP_PERIODS) + 1
"""Rows between two stretches, so that each is one."""
MOVES = ("steps_", "command", "theta_", "position", "distance")


def excerpt(
    recording: FlatRecording, most: int, every: int = 1, led_in: Collection[str] = ()
) -> FlatRecording:
    """The recording itself, or stretches of it with `most` rows together.

    every: only every so many rows are looked at. led_in: columns of readings, where the state of a
    machine depends on earlier commands; each stretch then begins with some of the rows before it,
    in which these columns are empty.
    """
    rows = recording.rows(slice(None, None, every)) if every > 1 else recording
    if len(rows) <= most:
        return rows
    length = most // STRETCHES
    leading = int(LED_IN * length) if led_in else 0
    chosen, lead = _chosen(rows, length - leading, leading)
    kept = rows.rows(chosen)
    blank = np.isin(chosen, lead)
    columns = {
        name: np.where(blank, np.nan, values) if name in led_in else values
        for name, values in kept.columns.items()
    }
    return replace(kept, columns=columns, taken_from=recording.taken_from or len(recording))


def _chosen(recording: FlatRecording, length: int, leading: int) -> tuple[IntArray, IntArray]:
    """Rows of the stretches, with a gap between each and the next, and those that lead to them."""
    count = len(recording)
    moved = np.concatenate([[0.0], np.cumsum(_moving(recording))])
    edges = np.linspace(0, count, STRETCHES + 1).astype(int)
    found, leads, free = [], [], 0
    for begin, end in itertools.pairwise(edges.tolist()):
        first = np.arange(begin, max(begin + 1, end - length - APART))
        best = int(first[np.argmax(moved[first + length - 1] - moved[first])])
        lead = best - LEAD_EVERY * np.arange(leading, 0, -1)
        leads.append(lead[lead >= free])
        free = min(best + length, count)
        found.append(np.arange(best, free))
    rows: IntArray = np.unique(np.concatenate([*found, *leads]))
    return rows, np.concatenate(leads)


def _moving(recording: FlatRecording) -> FloatArray:
    """How much moves from each row to the next, (n - 1,), each column in its own measure."""
    total = np.zeros(len(recording) - 1)
    for name, values in recording.columns.items():
        if name.startswith(MOVES):
            # Not by how much: all stretches would lie around a reading that leaps.
            total += np.nan_to_num(np.diff(values)) != 0.0
    return total
