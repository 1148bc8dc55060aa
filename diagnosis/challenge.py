"""Free shapes compete with the named effects: beside them, and instead of them."""

from __future__ import annotations

from diagnosis.blur import FREE
from diagnosis.detect import ALPHA
from diagnosis.free_shapes import FreeShape
from diagnosis.name import HOPE, Search
from diagnosis.prices import FREE_PRICE, price, price_of
from diagnosis.solution import Solution

MOST_RIVALS = 2
OPTIMISM = 1.5
"""How much more than its linearised gain an effect may bring."""


def challenge(search: Search, solution: Solution) -> Solution:
    """The solution, or the better story with a free shape in it."""
    best = solution
    beside = free_rivals(search, solution)
    starts = [(solution.terms, (*solution.frees, free)) for free in beside]
    named = solution.terms
    as_free = any(price_of(term) > price(term.candidate) for term in named)
    if len(named) > 1 or (named and starts) or as_free:
        starts += [((), (free,)) for free in free_rivals(search, search.empty)]
    for terms, frees in starts:
        rival = search.fitter.solve(terms, frees, solution.nuisances)
        if not terms and _hopeless(search, rival, best):
            continue
        rival = search.drop(rival)
        if not terms:
            rival = search.one_more(rival, solution)
        if search.story(rival) < search.story(best):
            best = rival
    return best


def free_rivals(search: Search, solution: Solution) -> list[FreeShape]:
    """Free shapes that explain most of what a solution leaves."""
    scores = search.scores(solution)
    ranked = [
        (entry.free, float(scores.gain[number]), float(scores.log_p[number]))
        for number, entry in enumerate(search.prepared.bank.entries)
        if entry.free is not None
    ]
    ranked += search.fine_scores(solution)
    ranked.sort(key=lambda item: item[2])
    least = max(FREE_PRICE, FREE * search.least_gain(solution))
    return [
        free
        for free, gain, log_p in ranked[:MOST_RIVALS]
        if gain > least and search.p(log_p) < ALPHA
    ]


def _hopeless(search: Search, rival: Solution, best: Solution) -> bool:
    """Whether a rival stays behind even with all that one more effect may add to it."""
    more = max((trial.gain for trial in search.trials(rival)), default=0.0)
    return search.worth(rival) - OPTIMISM * more > search.worth(best) + HOPE
