"""Moves that put one thing in the place of another: an effect, a pair, a group."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.priors.penalties import penalty
from deltactl.diagnosis.score_tests.pair_scores import best_pairs, leading
from deltactl.diagnosis.search.addition import add, falls_short, is_pile
from deltactl.diagnosis.search.begun_fits import begun, follow
from deltactl.diagnosis.search.removal import drop, each_left_out, first_of, left_out
from deltactl.diagnosis.search.state import SearchState, Without


def swapped(search: SearchState, solution: Solution) -> Solution:
    """With something better in the place of a term other than the newest."""
    tasks = [
        partial(another, search, solution, number, one.fit)
        for number, one in enumerate(each_left_out(search, solution)[:-1])
    ]
    return first_of(search.fitter.side_by_side(tasks)) or solution


def reconsidered(
    search: SearchState, solution: Solution, number: int
) -> tuple[Without, Solution | None]:
    """It without a term, and with something better in place of one other than the newest."""
    bare = left_out(search, solution, number)
    newest = number == len(solution.terms) - 1
    return bare, None if newest else another(search, solution, number, bare.fit)


def another(
    search: SearchState, solution: Solution, number: int, bare: Solution
) -> Solution | None:
    """Something better in place of one term, without which `bare` is left."""
    options, cost = search.options, search.criterion.penalised
    own, gain = solution.terms[number].candidate.key, bare.cost - solution.cost
    for trial in search.tests.trials(bare, [own])[: options.tried_instead]:
        if trial.gain < options.instead_share * gain:
            continue
        tried = begun(search.fitter, (*bare.terms, trial.start), bare, options)
        if not tried.within_reach(solution, gain, options):
            continue
        other = follow(search.fitter, tried)
        if cost(other) < cost(solution) - options.better:
            return other
    return None


def pair_instead(search: SearchState, before: Solution, grown: Solution) -> Solution | None:
    """Two others in place of the newest two, where these together do more."""
    if not before.terms:
        return None
    several = len(before.terms) > 1
    base = each_left_out(search, before)[-1].fit if several else search.tests.empty
    best = with_pair(search, base, grown, search.options.tried_pairs)
    return None if best is grown else best


def pairs_for_one(search: SearchState, solution: Solution) -> list[Callable[[], Solution]]:
    """What asks, for each term, whether it only looks like two others beside the rest."""
    few = 1 < len(solution.terms) < search.options.most_terms
    if not few or is_pile(search, solution):
        return []
    bares = [bare.fit for bare in each_left_out(search, solution)]
    return [partial(with_pair, search, bare, solution, 1) for bare in bares]


def best_of(search: SearchState, solution: Solution, found: Sequence[Solution]) -> Solution:
    """The best with two causes in place of one, where that is better."""
    best = min([solution, *found], key=search.criterion.penalised)
    return solution if best is solution else drop(search, best, solution)


def with_pair(search: SearchState, base: Solution, best: Solution, most: int) -> Solution:
    """The best so far, or a base with the two that do more together."""
    scorer, cost = search.prepared.scorer, search.criterion.penalised
    taken = {term.candidate.key for term in base.terms}
    entries = leading(scorer, search.tests.scores(base), taken)
    pairs = best_pairs(scorer, base.free_basis, base.residual, entries, penalty, most)
    known = {term.candidate.key for term in best.terms}
    for pair in pairs:
        if pair.value < cost(base) - cost(best) + search.options.least_more:
            break
        if taken | {start.candidate.key for start in pair.starts} == known:
            continue
        alternative = search.fitter.solve((*base.terms, *pair.starts), base.frees, base.nuisances)
        best = min(best, alternative, key=cost)
    return best


def group_instead(search: SearchState, solution: Solution) -> Solution | None:
    """A whole group instead of several effects, where it is the better explanation."""
    if len(solution.terms) < 2:
        return None
    empty, options, cost = search.tests.empty, search.options, search.criterion.penalised
    trials = search.tests.trials(empty, groups=True)
    least = options.group_share * (empty.cost - solution.cost)
    starts = [t.start for t in trials if t.start.candidate.members and t.gain > least]
    alternatives = search.fitter.side_by_side(
        [partial(_grown_from, search, start, solution) for start in starts[: options.groups]]
    )
    best = min([solution, *alternatives], key=cost)
    return None if best is solution else best


def _grown_from(search: SearchState, start: Term, solution: Solution) -> Solution:
    """A group with what else earns its place, as long as it may yet beat a solution."""
    alternative = search.fitter.solve((start,), (), search.tests.empty.nuisances)
    for left in range(max(len(solution.terms) - 2, 1), 0, -1):
        if falls_short(search, alternative, left, search.criterion.penalised(solution)):
            break
        grown = add(search, alternative, solution)
        if grown is None:
            break
        alternative = drop(search, grown)
    return alternative
