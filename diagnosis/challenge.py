"""Free shapes compete with the named effects: beside them, and instead of them."""

from __future__ import annotations

from functools import partial

from diagnosis.blur import FREE
from diagnosis.detect import ALPHA
from diagnosis.free_shapes import FreeShape
from diagnosis.name import Search
from diagnosis.prices import FREE_PRICE, free_price, price, price_of
from diagnosis.solution import Solution

MOST_RIVALS = 2


def challenge(search: Search, solution: Solution) -> Solution:
    """The solution, or the better story with a free shape in it."""
    beside = free_rivals(search, solution)
    starts = [(solution.terms, (*solution.frees, free)) for free in beside]
    named = solution.terms
    as_free = any(price_of(term) > price(term.candidate) for term in named)
    if len(named) > 1 or (named and starts) or as_free:
        starts += [((), (free,)) for free in free_rivals(search, search.empty)]
    begun = search.fitter.side_by_side(
        [partial(search.fitter.solve, *start, solution.nuisances) for start in starts],
        [free for _, frees in starts for free in frees],
    )
    begun.sort(key=_least_story)
    best = solution
    while (
        begun
    ):  # with a tangent worked out a rival is large: none is kept for longer than it takes
        grown = _grown(search, begun.pop(0), solution, best)
        best = best if grown is None else min(best, grown, key=search.story)
    return best


def _least_story(rival: Solution) -> float:
    """What a rival would be worth at least if none of its effects were needed."""
    return rival.cost + sum(free_price(free) for free in rival.frees)


def _grown(search: Search, rival: Solution, solution: Solution, best: Solution) -> Solution | None:
    """A rival that has a free shape, less what it does not need or with what else it needs; None
    for one that stays behind the best so far.
    """
    if rival.terms:
        return search.drop(rival) if _least_story(rival) < search.story(best) else None
    if search.falls_short(rival, 1, search.worth(best)):
        return None
    return search.one_more(search.drop(rival), solution)


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
