"""What effects that a robot file has from earlier diagnoses may leave of the shape of further ones.

Found in a recording, an effect and its discrepancy are weighed together. Once the file has it, the
same share must be allowed: the next diagnosis would take for a second effect what is the first.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.nuisance import Nuisance
from deltactl.diagnosis.priors.penalties import Trial, left_by, penalty
from deltactl.diagnosis.score_tests.chi2_tail import log_sf


class LeftByMeasured:
    """Chi-square by which each measured effect improves the fit, and what that may leave."""

    def __init__(self, fitter: Fitter, empty: Solution):
        known = [n.term.candidate.key for n in fitter.nuisances if n.measured]
        self.spreads = {
            key: nuisance.together or nuisance.spread[0]
            for key, (nuisance, _) in changing(fitter).items()
        }
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

    def is_change(self, new: Candidate) -> bool:
        """Whether a candidate is a measured effect that has another size by now."""
        return new.key in self.spreads

    def spread_of(self, new: Candidate) -> float | None:
        """How exactly the size of a measured effect is known, which a change must exceed."""
        return self.spreads.get(new.key)

    def charge(self, new: Candidate) -> float:
        """What a term must explain before it explains anything; a change has its prior for that."""
        return 0.0 if self.is_change(new) else self.of(new)


def held_to(fitter: Fitter) -> list[Nuisance]:
    """What the robot file holds a machine to: measured effects, and small errors of building where
    an earlier diagnosis needed them.
    """
    model = fitter.model
    small = {n.term.candidate.key for n in model.tolerances} if model.loosely_built else set()
    return [n for n in fitter.nuisances if n.measured or n.term.candidate.key in small]


def changing(fitter: Fitter) -> dict[tuple[str, ...], tuple[Nuisance, Candidate]]:
    """What is held and whose change a candidate is: those that have the same coordinates."""
    candidates = {one.key: one for one in fitter.model.candidates}
    pairs = [(n, candidates.get(n.term.candidate.key)) for n in held_to(fitter)]
    return {
        one.key: (nuisance, one)
        for nuisance, one in pairs
        if one is not None
        and len(one.coordinates) == len(nuisance.term.at)
        and len(nuisance.term.candidate.moved) == len(nuisance.term.at)
    }


def changed(fitter: Fitter, solution: Solution) -> list[Trial]:
    """Measured effects as far from what is known of them as they were fitted.

    By all their coordinates, or by what those amount to together: the discrepancy of a drive that
    follows late shifts its dead time against its time constant, and their sum much less.
    """
    now = {term.candidate.key: term for term in solution.nuisances}
    found = []
    for key, (nuisance, candidate) in changing(fitter).items():
        term = now[key]
        away = term.at - nuisance.term.at
        gain = float(np.sum((away / np.array(nuisance.spread)) ** 2))
        log_p = log_sf(gain, len(away))
        if nuisance.together is not None:
            of_sum = (float(away.sum()) / nuisance.together) ** 2
            gain, log_p = gain + of_sum, min(log_p, log_sf(of_sum, 1))
        found.append(Trial(Term(candidate, away), gain, log_p, penalty(candidate)))
    return found
