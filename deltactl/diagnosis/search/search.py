"""The search: add the best effect, refit all, swap, drop, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from deltactl.diagnosis.estimation.budget import Budget, Until
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.evidence.detection import Detection, Progress
from deltactl.diagnosis.evidence.noise_estimation import Prepared
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.priors.options import OPTIONS, SearchOptions
from deltactl.diagnosis.score_tests.score_test import Calibration
from deltactl.diagnosis.search.addition import add, onward
from deltactl.diagnosis.search.criterion import Criterion
from deltactl.diagnosis.search.exchange import (
    best_of,
    pair_instead,
    pairs_for_one,
    reconsidered,
    swapped,
)
from deltactl.diagnosis.search.removal import Without, drop, first_of, kept_without, left_out


@dataclass(slots=True, eq=False)
class Search:
    """The search for the set of effects that explains a recording.

    Its moves are functions: `addition`, `removal`, `exchange`. What it needs to know of the
    recording are its `tests`; by what one set is better than another says its `criterion`.
    """

    prepared: Prepared
    rad_per_step: float
    progress: Progress = lambda _: None
    known: Calibration | None = None
    """Of the same candidate library under nearly the same noise, where there is one."""
    options: SearchOptions = OPTIONS
    tests: Detection = field(init=False)
    criterion: Criterion = field(init=False)
    _last: tuple[Solution, list[Without]] | None = None
    """The solution that was last looked at without each of its terms; one, for it is large."""

    def __post_init__(self) -> None:
        self.tests = Detection(self.prepared, self.rad_per_step, self.progress, self.known)
        self.criterion = Criterion(self.tests, self.options)

    @property
    def fitter(self) -> Fitter:
        """The fitter of the prepared recording."""
        return self.prepared.fitter

    @property
    def budget(self) -> Budget:
        """How much more the search may be."""
        return self.fitter.budget

    def run(self) -> Solution:
        """The best set of named effects, one after the other."""
        return self.collected(self.tests.empty)

    def finished(self, solution: Solution) -> Solution:
        """The same, less what only came before others did."""
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
            self._remember(grown, [bare for bare, _ in looked])
        better = first_of([other for _, other in looked])
        if pair is not None:
            better = swapped(self, pair)
        return drop(self, grown if better is None else better, before)

    def one_more(self, solution: Solution, other: Solution) -> Solution:
        """A rival of another solution with a further effect, where one earns its place."""
        grown = add(self, solution, other)
        return solution if grown is None else drop(self, swapped(self, grown))

    def without(self, solution: Solution) -> list[Without]:
        """It without each of its terms in turn."""
        known = self.known_without(solution)
        if known is None:
            numbers = range(len(solution.terms))
            with self.budget.not_counted():
                known = self.fitter.side_by_side(
                    [partial(left_out, self, solution, number) for number in numbers]
                )
            known = self._remember(solution, known)
        return known

    def known_without(self, solution: Solution) -> list[Without] | None:
        """The same where it was looked at last."""
        return self._last[1] if self._last is not None and self._last[0] is solution else None

    def _remember(self, solution: Solution, found: Sequence[Without]) -> list[Without]:
        kept = kept_without(found)
        self._last = solution, kept
        return kept
