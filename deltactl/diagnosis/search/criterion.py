"""The criterion that compares sets of effects, and what an effect must gain to be in one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from deltactl.diagnosis.answer.verdict import ALARM
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.evidence.detection import Detection
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.priors.options import SearchOptions
from deltactl.diagnosis.priors.penalties import left_by, penalty_of, spline_penalty
from deltactl.diagnosis.score_tests.chi2_tail import log_sf
from deltactl.diagnosis.search.outside_contact import gain_elsewhere, local_terms
from deltactl.models.effects.kind import EXACT


@dataclass(slots=True, eq=False)
class Criterion:
    """Penalised cost of a set, and whether a term earns its place in one."""

    tests: Detection
    options: SearchOptions
    _parts: dict[tuple[tuple[str, ...], ...], float] = field(default_factory=dict)

    def penalised(self, solution: Solution) -> float:
        """Cost with the penalty of everything in it: the smaller the better."""
        penalties = sum(penalty_of(term) for term in solution.terms)
        shapes = sum(spline_penalty(free) for free in solution.frees)
        return solution.cost + penalties + shapes + self._left_by_measured(solution)

    def _left_by_measured(self, solution: Solution) -> float:
        """What effects of the robot file may leave in the shapes of what is in a solution."""
        left = self.tests.left_by_measured
        charges = sum(left.charge(term.candidate) for term in solution.terms)
        return charges + left.of() * len(solution.frees)

    def fully_penalised(self, solution: Solution) -> float:
        """Penalised cost, with what choosing each effect from all of them costs.

        A spline term has it in its penalty; a pile of effects in one covariate must not be free.
        """
        return self.penalised(solution) + self.options.choice * len(solution.terms)

    def least_gain(
        self, solution: Solution, new: Candidate | None = None, exact: Sequence[Term] = ()
    ) -> float:
        """What a new effect must explain at least: a share of what is explained already.

        Sharp effects count first, so that what two could explain is not charged as discrepancy.
        exact: terms that leave nothing in the readings that are looked at.
        """
        least, before = self.tests.left_by_measured.of(new), self.tests.empty.cost
        left = [EXACT if term in exact else left_by(term, new) for term in solution.terms]
        for share in sorted(set(left)):
            part = tuple(t for t, own in zip(solution.terms, left, strict=True) if own <= share)
            whole = part == solution.terms and not solution.frees
            now = solution.cost if whole else self._part(part)
            least, before = least + share * max(before - now, 0.0), min(now, before)
        return least + EXACT * max(before - solution.cost, 0.0)

    def _part(self, terms: tuple[Term, ...]) -> float:
        """Cost with some of the terms alone."""
        key = tuple(term.candidate.key for term in terms)
        if key not in self._parts:
            fitter = self.tests.fitter
            with fitter.budget.not_counted():
                self._parts[key] = fitter.solve(terms, (), self.tests.empty.nuisances, 2).cost
        return self._parts[key]

    def earns(self, without: Solution, found: Solution, new: Candidate) -> bool:
        """Whether an effect gains enough, everywhere or where nothing local misleads."""
        if self.tests.left_by_measured.is_change(new):
            return self.tests.changed(without, new.key)
        gain = without.cost - found.cost
        if not self.shows(gain, new):
            return False
        if gain >= self.least_gain(without, new):
            return True
        local = local_terms(without.terms)
        if not local or gain < self.least_gain(without, new, local):
            return False
        gain = gain_elsewhere(self.tests.fitter, without, found) / self.tests.tolerance_factor_of(
            new
        )
        return self.shows(gain, new)

    def shows(self, gain: float, new: Candidate) -> bool:
        """Whether a gain in chi-square is more than chance."""
        return self.tests.p(log_sf(gain, len(new.moved))) <= ALARM

    def clearly(self, without: Solution, found: Solution, new: Candidate) -> bool:
        """Whether an effect gains many times enough."""
        gain = (without.cost - found.cost) / self.options.clearly
        return self.shows(gain, new) and gain >= self.least_gain(without, new)
