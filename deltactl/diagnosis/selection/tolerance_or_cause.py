"""Whether build tolerances everywhere explain better than a pile of effects."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from deltactl.diagnosis.answer.verdict import ALARM
from deltactl.diagnosis.estimation.budget import Until
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.priors.penalties import Trial
from deltactl.diagnosis.priors.tolerances import effects_of_building, within_tolerance
from deltactl.diagnosis.search.outside_contact import clear_rows, left_near_contact
from deltactl.diagnosis.search.removal import drop
from deltactl.diagnosis.search.search import Search
from deltactl.models.effects import card_of


@dataclass(frozen=True, slots=True, eq=False)
class Needed:
    """What of a solution is needed beside build tolerances, and how large these are then."""

    terms: tuple[Term, ...]
    nuisances: tuple[Term, ...]
    penalised: float
    """Their cost with all penalties."""


class ToleranceOrCause:
    """The other explanation to that of a search: the same machine with build tolerances."""

    def __init__(self, search: Search):
        self.search = search

    @cached_property
    def other(self) -> Search:
        """The search in which small errors are always fitted."""
        search, model, few = self.search, self.search.prepared.model, self.search.prepared.fitter
        many = [*model.nuisances, *model.tolerances]
        fitter = Fitter(model, few.whiten, many, few.budget)
        loose = replace(search.prepared, fitter=fitter)
        return Search(loose, search.rad_per_step, search.progress, search.tests.calibration)

    def likely(self, solution: Solution) -> bool:
        """Whether to look: a pile of effects, or a rest that a wrong size would explain."""
        search = self.search
        tolerances = effects_of_building(search.prepared.model)
        if not solution.terms or not tolerances or search.prepared.model.loosely_built:
            return False
        rest = search.tests.trials(solution)
        rest_is_static = bool(rest) and self._is_static(solution, rest[0], tolerances)
        return len(solution.terms) >= search.options.pile or rest_is_static or self._small(solution)

    def _is_static(self, solution: Solution, trial: Trial, tolerances: Set[str]) -> bool:
        """Whether what scores best in the rest is a wrong size, and more than what is left anyway
        by effects that are not as simple as their operators.
        """
        search, new = self.search, trial.start.candidate
        if new.effect not in tolerances or search.tests.p(trial.log_p) >= ALARM:
            return False
        return trial.gain >= search.criterion.least_gain(solution, new)

    def needed(self, solution: Solution) -> Needed | None:
        """What is needed beside build tolerances, if these may explain better: some effect
        is not needed, or with all of them it is better already.
        """
        if not self.likely(solution):
            return None
        needed = drop(self.other, self.other.fitter.solve(solution.terms, solution.frees))
        if len(needed.terms) == len(solution.terms) and not self._better(solution, needed):
            return None
        return Needed(needed.terms, needed.nuisances, self.other.criterion.fully_penalised(needed))

    def instead(self, solution: Solution, needed: Needed) -> Solution | None:
        """Build tolerances with what else these need, where they are the better explanation.

        An effect that is itself such an error is not begun with. When they need nothing the search
        begins without effects: some of these only do what they do.
        """
        other, model = self.other, self.search.prepared.model
        begun = tuple(term for term in needed.terms if not within_tolerance(model, term))
        if not other.tests.any_shows(other.tests.trials(other.tests.empty)):
            found = other.run()
        elif begun == needed.terms:
            found = other.collected(other.fitter.solve(begun, (), needed.nuisances))
        else:
            found = other.resumed(begun, other.tests.empty.nuisances)
        if other.budget.lasts(Until.PAIRED):
            found = other.finished(found)
        alternative = self._promoted(found)
        return alternative if alternative.terms and self._better(solution, alternative) else None

    def _better(self, solution: Solution, alternative: Solution) -> bool:
        """Whether build tolerances explain better, judged where nothing local misleads.

        Not when it is one by an effect that would make the first as good, and was left out of it
        for what the others may leave.
        """
        clear = clear_rows(self.search.fitter, solution, alternative)
        many = left_near_contact(alternative, clear)
        evidence, penalised = (
            _evidence(self.other, alternative) - many,
            self.other.criterion.fully_penalised(alternative) - many,
        )

        def beats(one: Solution) -> bool:
            few = left_near_contact(one, clear)
            small = (
                self._small(one) and penalised < self.search.criterion.fully_penalised(one) - few
            )
            return small or evidence < _evidence(self.search, one) - few

        if not beats(solution):
            return False
        fairer = self._with_those_of(solution, alternative)
        return fairer is solution or beats(fairer)

    def _with_those_of(self, solution: Solution, alternative: Solution) -> Solution:
        """A solution with what another has beside it, where discrepancy kept that out."""
        search, own = self.search, {term.candidate.key for term in solution.terms}
        more = [term for term in alternative.terms if term.candidate.key not in own]
        if not more:
            return solution
        both = search.fitter.solve((*solution.terms, *more), solution.frees, solution.nuisances)
        most = max(search.criterion.least_gain(solution, term.candidate) for term in more)
        return both if solution.cost - both.cost < most else solution

    def _small(self, solution: Solution) -> bool:
        """Whether an error no larger than every machine may have is beside something else.

        By itself it is a finding; beside a fault it says how the machine was built.
        """
        model = self.search.prepared.model
        return len(solution.terms) > 1 and any(
            within_tolerance(model, term) for term in solution.terms
        )

    def _promoted(self, solution: Solution) -> Solution:
        """A wrong size that is too far off for a tolerance, though the priors nearly hide it.

        It must be more than what the effects that are there may leave.
        """
        other = self.other
        tolerances = effects_of_building(other.prepared.model)
        tolerances = {one for one in tolerances if card_of(one).build_spread is not None}
        static = [t for t in other.tests.trials(solution) if t.start.candidate.effect in tolerances]
        if not static:
            return solution
        least = other.criterion.least_gain(solution, static[0].start.candidate)
        promoted = max(self.search.options.promoted, least)
        if static[0].gain < promoted:
            return solution
        grown = other.fitter.solve(
            (*solution.terms, static[0].start), solution.frees, solution.nuisances
        )
        return grown if solution.cost - grown.cost > promoted else solution


def _evidence(search: Search, solution: Solution) -> float:
    """Cost with what choosing the terms and fitting the nuisances costs (Laplace)."""
    fitter = search.fitter
    count = sum(len(t.candidate.moved) for t in solution.nuisances)
    jac = solution.tangent[: fitter.rows, :count] * fitter.spread
    occam = float(np.linalg.slogdet(np.eye(count) + jac.T @ jac)[1])
    return (
        search.criterion.penalised(solution) + search.options.choice * len(solution.terms) + occam
    )
