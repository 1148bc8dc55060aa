"""What the answer says of something without a name at a place: size, covariates, memory, table.

Play, friction and filters remember: the same place gives another error when it is reached another
way. On a circle an arm's angle tells its speed, and no test on that circle can say which of them an
error follows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from deltactl.diagnosis.answer.finding import ParameterResult, Table
from deltactl.diagnosis.answer.options import VERDICT
from deltactl.diagnosis.assessment.intervals import NORMAL_95
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.delta.model import unit_at
from deltactl.diagnosis.plants.delta.noise_of_channels import ChannelsNoise
from deltactl.diagnosis.plants.delta.options import PROCESSES
from deltactl.diagnosis.plants.delta.recorded import Recorded
from deltactl.diagnosis.plants.delta.unknown import Process, Ways
from deltactl.diagnosis.plants.options import UNKNOWN


class Followed:
    """Processes of one place in an explanation."""

    def __init__(
        self,
        recorded: Recorded,
        noise: ChannelsNoise,
        processes: Sequence[Process],
        best: Explanation,
        without: Explanation,
    ):
        """without: the explanation less these processes."""
        self.recorded, self.noise, self.processes = recorded, noise, processes
        self.best, self.without = best, without
        self.gain = max(without.chi2 - best.chi2, 0.0)
        model, entries = recorded.model, [p.entry for one in processes for p in one.parts]
        moved = np.any([model.inputs()[entry] != 0.0 for entry in entries], axis=0)
        self._covariates = model.covariates()
        self._decided = np.any(moved & recorded.valid, axis=1)
        """Rows in which a reading tells of it; none holds it elsewhere."""
        self._unit = unit_at(entries[0])

    def fields(self) -> dict[str, Any]:
        """Fields of the finding."""
        tied = self._tied()
        own = [name for one in self.processes for name in one.follows]
        instead = [name for covariate in tied for name in covariate.split(", ")]
        return {
            "parameters": {"size_rms": self._size()},
            "depends_on": list(dict.fromkeys([*own, *instead])),
            "tied": list(dict.fromkeys(name for name in instead if name not in own)),
            "has_memory": self._has_memory(),
            "table": self._table(),
        }

    def _size(self) -> ParameterResult:
        values: dict[str, FloatArray] = {}
        for one in self.processes:
            for entry, shapes in one.entering(self.recorded.model).items():
                values[entry] = values.get(entry, 0.0) + shapes @ self.best.linear[one.key]
        size = math.hypot(*(float(np.std(own[self._decided])) for own in values.values()))
        half = NORMAL_95 * size / max(math.sqrt(self.gain), 1.0)
        return ParameterResult(value=size, ci95=[size - half, size + half], unit=self._unit)

    def _table(self) -> Table | None:
        """Numbers over the covariate, as far as readings tell of it; None of several."""
        (one, *more), part = self.processes, self.processes[0].single
        if more or part is None:
            return None
        seen = self._covariates[part.covariate][self._decided]
        places = np.linspace(float(seen.min()), float(seen.max()), UNKNOWN.places_in_table)
        size = one.over(places) @ self.best.linear[one.key]
        low, high = float(places[0]), float(places[-1])
        return Table(follows=part.covariate, lowest=low, highest=high, size=size.tolist())

    def _tied(self) -> list[str]:
        """Other covariates that explain at this place as much, the best first."""
        (one, *more) = self.processes
        if more or one.rate_hz or len(one.parts) > 1:
            return []
        every = self.recorded.processes.every
        alike = [x for x in every if (x[0].component, x[0].two_way) == (one.component, one.two_way)]
        gains = {x.parts[0].covariate: x.gain for x in self._probable(self.without, alike)}
        least = gains.pop(one.parts[0].covariate, math.inf) - PROCESSES.tied
        return [covariate for covariate, gain in gains.items() if gain > least]

    def _has_memory(self) -> bool | None:
        """Whether the past matters; None where too little is there to rule a memory out, and for
        time, which has no other past.
        """
        if any(one.two_way for one in self.processes):
            return True
        timeless = [one for one in self.processes if one.single and one.follows != ("time",)]
        pasts = [way for one in timeless for way in self.recorded.processes.remembering(one)]
        if not pasts:
            return None
        surely = math.log(len(pasts) / VERDICT.alarm)
        found = self._probable(self.best, pasts)
        least = PROCESSES.least_past * 0.5 * self.gain
        if any(one.gain - one.paid > max(surely, least) for one in found):
            return True
        return False if least > surely else None

    def _probable(self, beside: Explanation, among: Sequence[Ways]) -> list[Process]:
        known = self.recorded.processes
        return known.probable(self.noise, beside.residual, beside.tangent, among)
