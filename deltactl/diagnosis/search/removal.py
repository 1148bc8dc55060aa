"""Moves that take a term out: what each effect of a set is needed for, and the set without it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from deltactl.diagnosis.estimation.estimate import Solution, without
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.search.state import SearchState, Without


@dataclass(frozen=True, slots=True, eq=False)
class _Spared:
    """The rest of a solution where it can do without a term."""

    bare: Solution | None
    clearly_needed: bool


def left_out(search: SearchState, solution: Solution, number: int) -> Without:
    """A solution without one of its terms, the rest fitted again."""
    begun = begun_without(search, solution, number)
    return _refitted(
        search, solution, number, begun, clearly_needed(search, solution, number, begun)
    )


def each_left_out(search: SearchState, solution: Solution) -> list[Without]:
    """A solution without each of its terms in turn."""
    known = search.known_without(solution)
    if known is None:
        numbers = range(len(solution.terms))
        with search.budget.not_counted():
            known = search.fitter.side_by_side(
                [partial(left_out, search, solution, number) for number in numbers]
            )
        known = search.remember(solution, known)
    return known


def _refitted(
    search: SearchState, solution: Solution, number: int, begun: Solution, clearly: bool
) -> Without:
    """The rest without a term brought to its end; clearly: whether that was seen before."""
    known = _others(solution, number)
    fit = search.fitter.solve(begun.terms, begun.frees, begun.nuisances, known=known)
    new, criterion = solution.terms[number].candidate, search.criterion
    clearly = clearly or criterion.clearly(fit, solution, new)
    return Without(fit, clearly or criterion.earns(fit, solution, new), clearly)


def drop(
    search: SearchState,
    solution: Solution,
    before: Solution | None = None,
    sure: frozenset[tuple[str, ...]] = frozenset(),
) -> Solution:
    """Leave out whatever no longer earns its place.

    before: a solution of which everything is needed. sure: keys of what is clearly needed.
    """
    if len(solution.terms) + len(solution.frees) == 1:
        return solution
    if before is not None and _same_terms(solution, before):
        better = solution.cost < before.cost - search.options.better
        return solution if better else before
    known = search.known_without(solution)
    if known is not None:
        found = [_Spared(None if one.needed else one.fit, one.clearly) for one in known]
    else:
        found = _spared(search, solution, before, sure)
    bare = first_of([one.bare for one in found])
    if bare is None:
        return solution
    keys = [term.candidate.key for term in solution.terms]
    more = [key for key, one in zip(keys, found, strict=True) if one.clearly_needed]
    return drop(search, bare, before, sure.union(more))


def _spared(
    search: SearchState,
    solution: Solution,
    before: Solution | None,
    sure: frozenset[tuple[str, ...]],
) -> list[_Spared]:
    """The rest without each term that does not earn its place; first what one has more."""
    count = len(solution.terms)
    found = [_Spared(None, True)] * count
    asked = [k for k in range(count) if solution.terms[k].candidate.key not in sure]
    more = [] if before is None else _only_in(solution, before)
    if len(more) == 1:
        found[more[0]] = spare(search, solution, more[0])
        if found[more[0]].bare is not None:
            return [one if k in more else _Spared(None, False) for k, one in enumerate(found)]
        asked = [k for k in asked if k not in more]
    tasks = [partial(spare, search, solution, k) for k in asked]
    for k, one in zip(asked, search.fitter.side_by_side(tasks), strict=True):
        found[k] = one
    return found


def spare(search: SearchState, solution: Solution, number: int) -> _Spared:
    """The rest without a term that does not earn its place."""
    begun = begun_without(search, solution, number)
    if clearly_needed(search, solution, number, begun):
        return _Spared(None, True)
    left = _refitted(search, solution, number, begun, False)
    return _Spared(None if left.needed else left.fit, left.clearly)


def begun_without(search: SearchState, solution: Solution, number: int) -> Solution:
    """The first step in which the others make up for a term."""
    rest = without(solution.terms, number)
    known = _others(solution, number)
    return search.fitter.solve(rest, solution.frees, solution.nuisances, 1, known)


def clearly_needed(search: SearchState, solution: Solution, number: int, begun: Solution) -> bool:
    """Whether the others leave far too much after a step that they could take."""
    if not search.criterion.clearly(begun, solution, solution.terms[number].candidate):
        return False
    rest = without(solution.terms, number)
    before = search.fitter.solve(rest, solution.frees, solution.nuisances, 0)
    return begun.cost < before.cost


def first_of(found: Sequence[Solution | None]) -> Solution | None:
    """The first solution among them."""
    return next((one for one in found if one is not None), None)


def _others(solution: Solution, number: int) -> FloatArray:
    """The tangent less what belongs to one term or to spline terms, (m, p)."""
    return np.delete(solution.named_tangent, solution.columns_of(number), axis=1)


def _same_terms(one: Solution, other: Solution) -> bool:
    same = len(one.terms) == len(other.terms) and one.frees == other.frees
    return same and not _only_in(one, other)


def _only_in(one: Solution, other: Solution) -> list[int]:
    """Numbers of the terms that another solution does not have."""
    known = {term.candidate.key for term in other.terms}
    return [k for k, term in enumerate(one.terms) if term.candidate.key not in known]
