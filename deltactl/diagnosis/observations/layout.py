"""Columns of several joints or channels as one column, and the readings of that."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.observations.options import OBSERVATIONS
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray, Readings


class Layout:
    """How the columns of all joints, or of all that was measured, are one: one after another,
    section after section.

    Samples a filter's memory apart say all that passed the low-pass; the others are left out.

    Sections hold equally many rows that count, so that a share of the column left out is a time
    left out of all joints, as a size is to be foretold in another motion and not in another joint.
    """

    def __init__(self, counts: BoolArray, sections: int, stride: int = 1):
        """counts: (samples, columns); stride: samples from one that is kept to the next."""
        self.kept = np.arange(0, len(counts), stride)
        samples, self.width = len(self.kept), counts.shape[1]
        counted = np.cumsum(counts[self.kept].sum(axis=1))
        ends = np.searchsorted(counted, counted[-1] * np.arange(1, sections) / sections)
        section = np.searchsorted(ends, np.arange(samples), side="right")
        key = section[:, None] * self.width + np.arange(self.width)
        order = np.argsort(key.T.ravel(), kind="stable")
        self.column: IntArray = np.repeat(np.arange(self.width), samples)[order]
        self._row: IntArray = np.tile(np.arange(samples), self.width)[order]
        self.sample: IntArray = self.kept[self._row]

    def laid(self, values: FloatArray) -> FloatArray:
        """(samples, columns) or (samples, columns, k) as (n,) or (n, k)."""
        return values[self.sample, self.column]

    def apart(self, column: FloatArray) -> FloatArray:
        """(n,) as (samples, columns)."""
        made = np.empty((len(self.kept), self.width))
        made[self._row, self.column] = column
        return made

    def readings(self, whole: Readings, counts: BoolArray, channel: str, unit: str) -> Readings:
        """One channel in stretches of a column each, nothing observed yet; whole: when it was."""
        own_s, period_s = whole.t_s[self.sample], whole.period_s
        stretch = np.cumsum(whole.fresh)[self.sample]
        fresh = np.diff(stretch, prepend=-1) != 0
        fresh |= np.diff(self.column, prepend=-1) != 0
        fresh |= np.diff(self._row, prepend=-2) != 1
        step = np.diff(own_s, prepend=own_s[0])
        step[fresh] = OBSERVATIONS.between_recordings_s
        step[0] = 0.0
        t_s = own_s[0] + np.cumsum(np.maximum(step, 1e-3 * period_s))
        return Readings(
            t_s, fresh, whole.part[self.sample], whole.shift_s, (channel,), (unit,),
            np.zeros((len(t_s), 1)), counts[self.sample, self.column][:, None],
        )  # fmt: skip
