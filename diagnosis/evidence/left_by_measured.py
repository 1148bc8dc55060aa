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
from diagnosis.priors.penalties import Trial, penalty
from diagnosis.score_tests.chi2_tail import log_sf


class LeftByMeasured:
    """Chi-square by which each measured effect improves the fit, and what that may leave."""

    def __init__(self, fitter: Fitter, empty: Solution):
        self.spreads = {n.term.candidate.key: n.spread[0] for n in fitter.nuisances if n.measured}
        now = float(np.sum(empty.residual[: fitter.rows] ** 2))
        self.gains: list[tuple[Term, float]] = []
        power = np.zeros_like(empty.predicted)
        for number, term in enumerate(empty.nuisances):
            if term.candidate.key in self.spreads:
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

    def is_change(self, new: Candidate) -> bool:
        """Whether a candidate is a measured effect that has another size by now."""
        return new.key in self.spreads

    def spread_of(self, new: Candidate) -> float | None:
        """How exactly the size of a measured effect is known, which a change must exceed."""
        return self.spreads.get(new.key)

    def charge(self, new: Candidate) -> float:
        """What a term must explain before it explains anything; a change has its prior for that."""
        return 0.0 if self.is_change(new) else self.of(new)


def changed(fitter: Fitter, solution: Solution) -> list[Trial]:
    """Measured effects as far from what is known of them as they were fitted.

    What each gains is what its prior costs there.
    """
    candidates = {one.key: one for one in fitter.model.candidates}
    found = []
    for nuisance, term in zip(fitter.nuisances, solution.nuisances, strict=True):
        candidate = candidates.get(term.candidate.key)
        if not nuisance.measured or candidate is None:
            continue
        away = term.at - nuisance.term.at
        gain = float(np.sum((away / np.array(nuisance.spread)) ** 2))
        log_p = log_sf(gain, len(away))
        found.append(Trial(Term(candidate, away), gain, log_p, penalty(candidate)))
    return found
