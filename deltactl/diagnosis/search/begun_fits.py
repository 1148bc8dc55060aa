"""Fits that are only begun, and the few of them that are finished."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.splines import SplineTerm
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.priors.options import SearchOptions


@dataclass(frozen=True, slots=True, eq=False)
class Tried:
    """What is kept of a fit that was only begun."""

    terms: tuple[Term, ...]
    nuisances: tuple[Term, ...]
    frees: tuple[SplineTerm, ...]
    cost: float

    def within_reach(self, solution: Solution, gain: float, options: SearchOptions) -> bool:
        """Whether it may yet do what a solution does that is so much better without the
        alternative."""
        return self.cost - solution.cost < max(options.reach, options.reach_share * gain)


Start = tuple[tuple[Term, ...], Solution]
"""Terms (those of another solution first), and that solution, which has the rest."""


def tried(fitter: Fitter, starts: Sequence[Start], options: SearchOptions) -> list[Tried]:
    """Fits that are only begun, side by side."""
    return fitter.side_by_side([partial(begun, fitter, *start, options) for start in starts])


def begun(
    fitter: Fitter, terms: tuple[Term, ...], beside: Solution, options: SearchOptions
) -> Tried:
    """One of them."""
    known = beside.named_tangent
    one = fitter.solve(terms, beside.frees, beside.nuisances, options.quick, known)
    return Tried(one.terms, one.nuisances, one.frees, one.cost)


def followed(fitter: Fitter, begun_: Sequence[Tried]) -> list[Solution]:
    """Fits that were begun, brought to their end side by side."""
    return fitter.side_by_side([partial(follow, fitter, one) for one in begun_])


def follow(fitter: Fitter, one: Tried) -> Solution:
    """One of them."""
    return fitter.solve(one.terms, one.frees, one.nuisances)


def promising(before: Solution, tried_: Sequence[Tried], options: SearchOptions) -> list[Tried]:
    """Fits that may yet become the best of those that were begun."""
    most = max((before.cost - one.cost for one in tried_), default=0.0)
    least = min(options.hopeful * most, most - options.hope)
    return [one for one in tried_ if before.cost - one.cost >= least]
