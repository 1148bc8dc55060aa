"""Spline terms compete with the named effects: beside them, and instead of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from deltactl.diagnosis.answer.verdict import ALARM
from deltactl.diagnosis.estimation.budget import Until
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.splines import SplineTerm
from deltactl.diagnosis.priors.options import PENALTIES
from deltactl.diagnosis.priors.penalties import penalty, penalty_of, spline_penalty
from deltactl.diagnosis.priors.tolerances import effects_of_building
from deltactl.diagnosis.search.addition import falls_short
from deltactl.diagnosis.search.outside_contact import gain_elsewhere, local_terms
from deltactl.diagnosis.search.removal import drop
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.options import CREDIBLE


def with_spline_terms(search: Search, solution: Solution) -> Solution:
    """Spline terms beside or instead of the named effects, as long as one more earns its place.

    What one shape leaves at its own location is its discrepancy and earns no second one there.
    """
    for _ in range(search.options.most_shapes):
        if solution.frees and not search.budget.lasts(Until.SHAPED):
            return solution
        if not solution.terms and not solution.frees and search.tests.first_p() > ALARM:
            return solution
        taken = {free.location for free in solution.frees}
        if taken and all(free.location in taken for free in free_alternatives(search, solution)):
            return solution
        challenged = challenge(search, solution)
        if len(challenged.frees) == len(solution.frees):
            return challenged
        if len({free.location for free in challenged.frees}) < len(challenged.frees):
            return solution
        solution = challenged
    return solution


@dataclass(frozen=True, slots=True, eq=False)
class InPlace:
    """What a solution is without one of its spline terms."""

    bare: Solution
    """With nothing in its place."""
    named: Solution | None
    """With the named effect in its place that explains most of what the spline term did."""


def in_place_of(search: Search, solution: Solution, free: SplineTerm) -> InPlace:
    """A solution without a spline term, and with a named effect instead: fitted, for a score
    promises more than a bent effect can keep.
    """
    others = tuple(one for one in solution.frees if one is not free)
    solve = search.fitter.solve
    bare = solve(solution.terms, others, solution.nuisances, steps=CREDIBLE.bare_steps)
    named = [
        solve((*solution.terms, trial.start), others, solution.nuisances)
        for trial in search.tests.trials(bare)[:1]
    ]
    return InPlace(bare, next(iter(named), None))


def named_instead(search: Search, solution: Solution) -> tuple[Solution, dict[SplineTerm, InPlace]]:
    """The same with named effects in the place of spline terms, where that explains it better; and
    what was fitted in the place of each that stays.

    A spline term competes with the effects that the search had chosen; this one it may never have
    been compared with. Not where effects are beside it: several that bend together imitate what
    acts outside the vocabulary, and it is the better for being named so.
    """
    fitted: dict[SplineTerm, InPlace] = {}
    for free in () if solution.terms else solution.frees:
        fitted[free] = in_place_of(search, solution, free)
        named = fitted[free].named
        cost = search.criterion.fully_penalised
        if named is not None and cost(named) < cost(solution):
            return named_instead(search, drop(search, named))
    return solution, fitted


def shape_promises(search: Search, solution: Solution, penalised: float) -> bool:
    """Whether a spline term, instead of a solution or beside it, does better than an
    alternative."""
    return any(
        one.cost - gain + spline_penalty(free) < penalised
        for one in (search.tests.empty, solution)
        for free, gain, _ in search.tests.fine_scores(one)
    )


def explains_it_all(search: Search, shaped: Solution, penalised: float) -> bool:
    """Whether spline terms do far more than another explanation, and leave next to nothing.

    Alone, or beside what is named at the same places and no machine has by its building.
    """
    inputs = {free.location for free in shaped.frees}
    small = effects_of_building(search.prepared.model)
    beside = [term.candidate for term in shaped.terms]
    if not inputs or any(one.component not in inputs or one.effect in small for one in beside):
        return False
    left = max((trial.gain for trial in search.tests.trials(shaped)), default=0.0)
    return left < search.options.spare * (penalised - search.criterion.fully_penalised(shaped))


def challenge(search: Search, solution: Solution) -> Solution:
    """The solution, or the better explanation with a spline term in it."""
    beside = free_alternatives(search, solution)
    starts = [(solution.terms, (*solution.frees, free)) for free in beside]
    named = solution.terms
    as_free = any(penalty_of(term) > penalty(term.candidate) for term in named)
    if len(named) > 1 or (named and starts) or as_free:
        # Far-off effects may hold each other up: what a shape does instead of all is asked, too.
        alone = [
            *free_alternatives(search, search.tests.empty),
            *(beside if not solution.frees else ()),
        ]
        starts += [((), (free,)) for free in dict.fromkeys(alone)]
    begun = search.fitter.side_by_side(
        [partial(search.fitter.solve, *start, solution.nuisances) for start in starts],
        [free for _, frees in starts for free in frees],
    )
    begun.sort(key=_least_penalised)
    # The likeliest comes first: most of the others are then seen to stay behind.
    best = _best_grown(search, begun[:1], solution, solution)
    if len(begun) > 1 and search.budget.lasts(Until.SHAPED):
        best = _best_grown(search, begun[1:], solution, best)
    return best


def _best_grown(
    search: Search, alternatives: Sequence[Solution], solution: Solution, best: Solution
) -> Solution:
    """The best so far, or an alternative of a solution that is the better explanation."""
    grown = search.fitter.side_by_side(
        [partial(_grown, search, alternative, solution, best) for alternative in alternatives],
        [free for alternative in alternatives for free in alternative.frees],
    )
    fit = [one for one in grown if one is not None and seen_apart(search, solution, one)]
    return min([best, *fit], key=search.criterion.fully_penalised)


def seen_apart(search: Search, solution: Solution, alternative: Solution) -> bool:
    """Whether a shape beside what acts only now and then also shows where that does not act.

    How a table yields under the platform follows the place as well, and is no second cause.
    """
    if not local_terms(alternative.terms) or len(alternative.frees) <= len(solution.frees):
        return True
    gained = gain_elsewhere(search.fitter, solution, alternative)
    return gained > spline_penalty(alternative.frees[-1])


def _least_penalised(alternative: Solution) -> float:
    """The least penalised cost of an alternative if none of its effects were needed."""
    return alternative.cost + sum(spline_penalty(free) for free in alternative.frees)


def _grown(
    search: Search, alternative: Solution, solution: Solution, best: Solution
) -> Solution | None:
    """An alternative that has a spline term, less what it does not need or with what else it needs;
    None for one that stays behind the best so far.
    """
    if alternative.terms:
        return (
            drop(search, alternative)
            if _least_penalised(alternative) < search.criterion.fully_penalised(best)
            else None
        )
    if falls_short(search, alternative, 1, search.criterion.penalised(best)):
        return None
    return search.one_more(drop(search, alternative), solution)


def free_alternatives(search: Search, solution: Solution) -> list[SplineTerm]:
    """Spline terms that explain most of what a solution leaves."""
    scores = search.tests.scores(solution)
    ranked = [
        (entry.free, float(scores.gain[number]), float(scores.log_p[number]))
        for number, entry in enumerate(search.prepared.library.entries)
        if entry.free is not None
    ]
    ranked += search.tests.fine_scores(solution)
    ranked.sort(key=lambda item: item[2])
    least = max(PENALTIES.spline, PENALTIES.spline_factor * search.criterion.least_gain(solution))
    return [
        free
        for free, gain, log_p in ranked[: search.options.alternative_shapes]
        if gain > least and search.tests.p(log_p) < ALARM
    ]
