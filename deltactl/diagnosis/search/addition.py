"""Moves that put a term in: the best further effect, and when no further one earns its penalty."""

from __future__ import annotations

from collections.abc import Sequence

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.priors.options import SearchOptions
from deltactl.diagnosis.priors.penalties import Trial, spline_penalty
from deltactl.diagnosis.search.begun_fits import followed, promising, tried
from deltactl.diagnosis.search.state import SearchState


def onward(search: SearchState, solution: Solution) -> Solution | None:
    """With one more effect, unless these are enough."""
    if len(solution.terms) >= search.options.most_terms or is_pile(search, solution):
        return None
    return add(search, solution)


def add(search: SearchState, solution: Solution, other: Solution | None = None) -> Solution | None:
    """With the best further effect; where another explanation is known, with few or one of that."""
    options = search.options
    trials = search.tests.trials(solution)
    if not search.tests.any_shows(trials):
        return None
    worthy = likely(trials, options)
    if other is not None:
        told = {term.candidate.key for term in other.terms}
        first = worthy[: options.tried_of_alternatives]
        worthy = [t for t in worthy if t in first or t.start.candidate.key in told]
    search.progress(f"trying {len(worthy)} explanations")
    starts = [((*solution.terms, t.start), solution) for t in worthy]
    begun = promising(solution, tried(search.fitter, starts, options), options)
    best = min(followed(search.fitter, begun), key=search.criterion.penalised)
    new = best.terms[-1].candidate
    return best if search.criterion.earns(solution, best, new) else None


def likely(trials: Sequence[Trial], options: SearchOptions) -> list[Trial]:
    """Those to be fitted, of trials that are sorted by what they promise.

    Where these miss what build tolerances are least able to explain, it is tried as well.
    """
    first = list(trials[: options.tried])
    lasting = [t for t in trials if not t.start.candidate.kind.event]
    surest = sorted(lasting, key=lambda t: t.log_p)[: options.tried_by_p]
    if surest and surest[0] not in first:
        first += [t for t in surest if t not in first]
    return [t for t in first if t.gain > options.tried_share * trials[0].gain]


def is_pile(search: SearchState, solution: Solution) -> bool:
    """Whether so many effects explain less than one spline term: time to stop piling up."""
    if len(solution.terms) < search.options.pile:
        return False
    fine = search.tests.fine_scores(search.tests.empty)
    best = max((gain - spline_penalty(free) for free, gain, _ in fine), default=0.0)
    return search.tests.empty.cost - best < search.criterion.penalised(solution)


def falls_short(search: SearchState, alternative: Solution, more: int, cost: float) -> bool:
    """Whether an alternative stays behind even with all that so many more effects may add to it."""
    gains = sorted((trial.gain for trial in search.tests.trials(alternative)), reverse=True)
    least = search.criterion.penalised(alternative) - search.options.optimism * sum(gains[:more])
    return least > cost + search.options.hope
