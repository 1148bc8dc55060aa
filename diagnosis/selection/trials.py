"""Trying: fits that are only begun, and the few of them that are worth bringing to their end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.splines import FreeShape
from diagnosis.evidence.detection import Detection
from diagnosis.plants.candidate import Term

QUICK = 2
"""Steps of a first try."""
HOPEFUL, HOPE = 0.7, 40.0
"""Share of the best first try's gain, and chi-square behind it, with which a fit is followed."""
REACH, REACH_SHARE = 300.0, 0.05
"""Chi-square, and share of what a term explains, that a rival may still catch up after a try."""


@dataclass(frozen=True, slots=True, eq=False)
class Tried:
    """What is kept of a fit that was only begun."""

    terms: tuple[Term, ...]
    nuisances: tuple[Term, ...]
    frees: tuple[FreeShape, ...]
    cost: float

    def within_reach(self, solution: Solution, gain: float) -> bool:
        """Whether it may yet do what a solution does that is so much better without the rival."""
        return self.cost - solution.cost < max(REACH, REACH_SHARE * gain)


@dataclass(slots=True, eq=False)
class Trying(Detection):
    """Fits from where another solution has the rest, in two rounds."""

    def tried(self, rivals: Sequence[tuple[tuple[Term, ...], Solution]]) -> list[Tried]:
        """Fits of terms that are only begun, with the rest from where another solution has it."""
        return self.fitter.side_by_side([partial(self.begun, *rival) for rival in rivals])

    def begun(self, terms: tuple[Term, ...], beside: Solution) -> Tried:
        """The fit of terms (those of another solution first), only begun."""
        one = self.fitter.solve(terms, beside.frees, beside.nuisances, QUICK, beside.named_tangent)
        return Tried(one.terms, one.nuisances, one.frees, one.cost)

    def followed(self, tried: Sequence[Tried]) -> list[Solution]:
        """Fits that were begun, brought to their end."""
        return self.fitter.side_by_side([partial(self.follow, one) for one in tried])

    def follow(self, tried: Tried) -> Solution:
        """One of them."""
        return self.fitter.solve(tried.terms, tried.frees, tried.nuisances)


def promising(before: Solution, tried: Sequence[Tried]) -> list[Tried]:
    """Fits that may yet become the best of those that were begun."""
    most = max((before.cost - one.cost for one in tried), default=0.0)
    least = min(HOPEFUL * most, most - HOPE)
    return [one for one in tried if before.cost - one.cost >= least]
