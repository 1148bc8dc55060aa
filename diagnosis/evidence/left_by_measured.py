"""What effects that a robot file has from earlier diagnoses may leave of the shape of further ones.

Found in a recording, an effect and its discrepancy are weighed together. Once the file has it, the
same share must be allowed: the next diagnosis would take for a second effect what is the first.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.least_squares import Fitter
from diagnosis.observations.readings import FloatArray
from diagnosis.plants.candidate import Candidate, Term
from diagnosis.priors.discrepancy import left_by


class LeftByMeasured:
    """Chi-square by which each measured effect improves the fit, and what that may leave."""

    def __init__(self, fitter: Fitter, empty: Solution):
        known = [n.term.candidate.key for n in fitter.nuisances if n.measured]
        now = float(np.sum(empty.residual[: fitter.rows] ** 2))
        self.gains: list[tuple[Term, float]] = []
        power = np.zeros_like(empty.predicted)
        for number, term in enumerate(empty.nuisances):
            if term.candidate.key in known:
                others = [*empty.nuisances[:number], *empty.nuisances[number + 1 :]]
                without = fitter.model.predict(others)
                left = fitter.whiten(fitter.observed - without)
                self.gains.append((term, max(float(left @ left) - now, 0.0)))
                power += left_by(term) * (empty.predicted - without) ** 2
        self.size: FloatArray = np.sqrt(power)
        """How large that is in the channels, (n, channels)."""

    def of(self, new: Candidate | None = None) -> float:
        """Chi-square left in the shape of a new effect, or in that of a spline term."""
        return sum(left_by(term, new) * gain for term, gain in self.gains)

    def of_all(self, entries: Sequence[Candidate | None]) -> FloatArray:
        """The same of many, (entries,)."""
        return np.array([self.of(one) for one in entries]) if self.gains else np.zeros(len(entries))
