"""The search: add the best effect, refit all, swap, drop, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from deltactl.diagnosis.estimation.budget import Until
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.search.addition import add, onward
from deltactl.diagnosis.search.exchange import (
    best_of,
    pair_instead,
    pairs_for_one,
    reconsidered,
    swapped,
)
from deltactl.diagnosis.search.removal import drop, first_of
from deltactl.diagnosis.search.state import SearchState


@dataclass(slots=True, eq=False)
class Search(SearchState):
    """The search for the set of effects that explains a recording.

    Its moves are functions: `addition`, `removal`, `exchange`.
    """

    def run(self) -> Solution:
        """The best set of named effects, one after the other."""
        return self.collected(self.tests.empty)

    def finished(self, solution: Solution) -> Solution:
        """The set without terms that were only needed before others came in."""
        return best_of(self, solution, self.fitter.side_by_side(pairs_for_one(self, solution)))

    def resumed(self, terms: Sequence[Term], nuisances: Sequence[Term]) -> Solution:
        """The same, from a set that was found under other noise or beside others."""
        return self.collected(drop(self, self.fitter.solve(terms, (), nuisances)))

    def collected(self, solution: Solution) -> Solution:
        """The same, from a set of which everything is needed."""
        for _ in range(self.options.most_turns):
            grown = onward(self, solution)
            if grown is None:
                break
            if not self.budget.lasts(Until.GROWN):
                return drop(self, grown, solution)
            before, solution = solution, self._taken_in(solution, grown)
            if solution is before:  # it would only grow the same way again
                break
        return solution

    def _taken_in(self, before: Solution, grown: Solution) -> Solution:
        """A set that has grown, with what is better in it, less what it no longer needs."""
        several = range(len(grown.terms) if len(grown.terms) > 1 else 0)
        tasks: list[Callable[[], Any]] = [
            partial(pair_instead, self, before, grown),
            *(partial(reconsidered, self, grown, number) for number in several),
        ]
        pair, *looked = self.fitter.side_by_side(tasks)
        if several:
            self.remember(grown, [bare for bare, _ in looked])
        better = first_of([other for _, other in looked])
        if pair is not None:
            better = swapped(self, pair)
        return drop(self, grown if better is None else better, before)

    def one_more(self, solution: Solution, other: Solution) -> Solution:
        """An alternative of another solution with a further effect, where one earns its place."""
        grown = add(self, solution, other)
        return solution if grown is None else drop(self, swapped(self, grown))
