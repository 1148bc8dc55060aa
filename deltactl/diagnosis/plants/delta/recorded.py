"""What of a delta and its recordings does not change with the point that all is linear near."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from deltactl.diagnosis.observations.readings import (
    BoolArray,
    FloatArray,
    IntArray,
    without_outliers,
)
from deltactl.diagnosis.observations.stale_readings import without_stale
from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.plants.delta.beside_point import Starts
from deltactl.diagnosis.plants.delta.model import RANGES, DeltaModel
from deltactl.diagnosis.plants.delta.point import (
    Around,
    end_to_end,
    is_straight,
    key_of,
    side_by_side,
)
from deltactl.diagnosis.plants.delta.unknown import Processes
from deltactl.diagnosis.plants.nuisance import Nuisance


class Recorded:
    """What does not change with the point: the machine, its readings, columns of tolerances."""

    def __init__(self, model: DeltaModel):
        self.model, readings = model, model.readings
        self.observed = end_to_end(np.nan_to_num(readings.values))
        self.nominal = Around(model, ())
        left = side_by_side(self.observed - self.nominal.predicted, len(readings.names))
        kept, self.stale = without_stale(readings, RANGES)
        self.valid: BoolArray = without_outliers(left, kept)
        able = [one for one in model.candidates if one.shapes]
        self.candidates: dict[str, Candidate] = {key_of(one): one for one in able}

    @cached_property
    def processes(self) -> Processes:
        """What has no name."""
        return Processes(self.model)

    @cached_property
    def starts(self) -> Starts:
        """Scores of the shapes of effects."""
        return Starts(self.nominal)

    @cached_property
    def free(self) -> tuple[FloatArray, FloatArray, list[str], int]:
        """Columns (n c, p) of nuisances and tolerances, their spreads and names, how many are
        nuisances.
        """
        model = self.model
        known = {n.term.candidate.key for n in model.nuisances}
        tolerances = [n for n in model.tolerances if n.term.candidate.key not in known]
        columns: list[FloatArray] = []
        spreads: list[float] = []
        names: list[str] = []
        for nuisance in (*model.nuisances, *tolerances):
            slopes = self._slopes(nuisance)
            columns.append(slopes @ nuisance.directions)
            spreads += nuisance.spread
            one = nuisance.term.candidate
            names += [key_of(one)] * slopes.shape[1]
        first = sum(len(n.spread) for n in model.nuisances)
        return np.concatenate(columns, axis=1), np.array(spreads), names, first

    def _slopes(self, nuisance: Nuisance) -> FloatArray:
        around, term = self.nominal, nuisance.term
        if any(one is term for one in around.always):
            return around.always_slopes(term)
        own = self.candidates.get(key_of(term.candidate))
        if own is term.candidate and is_straight(own):
            return self.starts.straight(own)
        return around.slopes(term, around.predicted)

    @cached_property
    def held(self) -> IntArray:
        """Numbers of the free columns of what the file has from an earlier diagnosis."""
        every = self.model.nuisances
        counts = [len(one.spread) for one in every]
        return np.flatnonzero(np.repeat([one.held for one in every], counts))
