"""How the rows of a recording were read, as far as their noise depends on it."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from deltactl.diagnosis.observations.largest_noise import (
    Bound,
    NoiseBounds,
    remembering,
    segment_for,
    spectrum,
)
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray, Readings
from deltactl.diagnosis.plants.regressor import Sizes


class AsRead:
    """The part of a plant that says so; by default all rows are read alike."""

    readings: Readings
    kinds: IntArray
    """(n,) small numbers: rows of one kind are like one another (at rest, in motion, a joint)."""
    rounding = 0.0
    """Standard deviation of the rounding of a reading, in `unit`."""
    asked_rounding = 0.0
    """Standard deviation of the rounding of a command, in `unit`,"""
    asked: IntArray | None = None
    """and (n,) the number of each place that was commanded, where it is the same each time."""
    averages = False
    """Whether noise of neighbouring readings is alike: a sensor that averages over time."""

    @cached_property
    def t_s(self) -> FloatArray:
        """(n,) [s] in which noise is remembered; recordings and columns are end to end."""
        return self.readings.t_s

    @cached_property
    def groups(self) -> IntArray:
        """(n,) number of the stretch, place or joint of a row: noise is of one kind within."""
        return np.cumsum(self.readings.fresh).astype(np.intp)

    @property
    def noises(self) -> IntArray:
        """(n,) small numbers: rows of one number share one noise; as `kinds`, or coarser."""
        return self.kinds

    @cached_property
    def counts(self) -> FloatArray:
        """(n,) weight of a reading in figures of the model error: 0 where its unit is another."""
        return np.ones(len(self.t_s))

    @property
    def stays(self) -> IntArray:
        """Number (n,) of the stay at one place that a row belongs to; -1 in motion."""
        return np.full(len(self.groups), -1, dtype=np.intp)

    @property
    def unsampled(self) -> FloatArray | None:
        """(n,) standard deviation of a prediction by the course of a command between samples."""
        return None

    def without_noise(self, keys: frozenset[str], sizes: Sizes) -> BoolArray | None:
        """Rows (n,) that the prediction leaves no noise of, as it takes them from what was read."""
        return None

    def noise_bounds(self, left: FloatArray) -> NoiseBounds | None:
        """What bounds the noise in a residual (n,), where every row is read like its neighbours;
        None where too little was read in a row.
        """
        read = np.flatnonzero(self.readings.valid[:, 0])  # also rows that are thinned out
        seen = spectrum(left[read], self.groups[read], segment_for(len(read)))
        if seen is None:
            return None
        shapes = remembering(seen.angle)
        return NoiseBounds([Bound(seen, shapes)], np.ones(shapes.shape[1]))
