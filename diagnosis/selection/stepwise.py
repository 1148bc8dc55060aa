"""Naming: add the best effect, refit all, swap, drop, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from diagnosis.estimation.budget import Until
from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.penalties import free_price, price
from diagnosis.evidence.pair_scores import best_pairs, leading
from diagnosis.plants.candidate import Term
from diagnosis.selection.leave_out import LeavingOut, first_of
from diagnosis.selection.trials import HOPE, promising

CHOICE = 12.0
"""Chi-square that choosing one of a hundred candidates is worth."""
TRIED = 6
TRIED_OF_RIVALS = 2
OPTIMISM = 1.5
"""How much more than its linearised gain an effect may bring."""
TRIED_PAIRS = 3
LEAST_MORE = 5.0
"""What two others must promise beyond the newest two for a refit to be worth its time."""
MOST_TERMS = 5
PILE = 3
"""So many effects may be a pile that stands for one cause in no list."""
MOST_TURNS = 8


@dataclass(slots=True, eq=False)
class Search(LeavingOut):
    """The search for the set of effects that explains a recording."""

    def run(self) -> Solution:
        """The best set of named effects, one after the other."""
        return self.collected(self.empty)

    def finished(self, solution: Solution) -> Solution:
        """The same, less what only came before others did."""
        return self.best_pair(solution, self.fitter.side_by_side(self.doubted(solution)))

    def resumed(self, terms: Sequence[Term], nuisances: Sequence[Term]) -> Solution:
        """The same, from a set that was found under other noise or beside others."""
        return self.collected(self.drop(self.fitter.solve(terms, (), nuisances)))

    def collected(self, solution: Solution) -> Solution:
        """The same, from a set of which everything is needed."""
        grown = self._onward(solution)
        for _ in range(MOST_TURNS):
            if grown is None:
                break
            if not self.patience.lasts(Until.GROWN):
                return self.drop(grown, solution)
            solution, grown = self._taken_in(solution, grown)
        return solution

    def _onward(self, solution: Solution) -> Solution | None:
        """With one more effect, unless these are enough."""
        if len(solution.terms) >= MOST_TERMS:
            return None
        if len(solution.terms) >= PILE and self._free_explains_more(solution):
            return None
        return self._add(solution)

    def _taken_in(self, before: Solution, grown: Solution) -> tuple[Solution, Solution | None]:
        """A set that has grown, less what it no longer needs, and what it grows into next.

        Most sets stay as they have grown: the next effect is looked for at the same time.
        """
        several = range(len(grown.terms) if len(grown.terms) > 1 else 0)
        tasks: list[Callable[[], Any]] = [
            partial(self._onward, grown),
            partial(self._pair_instead, before, grown),
            *(partial(self.reconsidered, grown, number) for number in several),
        ]
        ahead, pair, *looked = self.fitter.side_by_side(tasks)
        if several:
            self.remember(grown, [bare for bare, _ in looked])
        better = first_of([other for _, other in looked]) if pair is None else self.swapped(pair)
        solution = self.drop(grown if better is None else better, before)
        if solution is before:  # it would only grow the same way again
            return before, None
        return solution, ahead if solution is grown else self._onward(solution)

    def _pair_instead(self, before: Solution, grown: Solution) -> Solution | None:
        """Two others in place of the newest two, where these together do more."""
        if not before.terms:
            return None
        base = self.without(before)[-1].fit if len(before.terms) > 1 else self.empty
        best = self._with_pair(base, grown, TRIED_PAIRS)
        return None if best is grown else best

    def doubted(self, solution: Solution) -> list[Callable[[], Solution]]:
        """What asks, for each term, whether it only looks like two others beside the rest."""
        few = 1 < len(solution.terms) < MOST_TERMS
        if not few or (len(solution.terms) >= PILE and self._free_explains_more(solution)):
            return []
        bares = [bare.fit for bare in self.without(solution)]
        return [partial(self._with_pair, bare, solution, 1) for bare in bares]

    def best_pair(self, solution: Solution, found: Sequence[Solution]) -> Solution:
        """The best with two causes in place of one, where that is better."""
        best = min([solution, *found], key=self.worth)
        return solution if best is solution else self.drop(best, solution)

    def _with_pair(self, base: Solution, best: Solution, most: int) -> Solution:
        """The best so far, or a base with the two that do more together."""
        scorer, taken = self.prepared.scorer, {term.candidate.key for term in base.terms}
        entries = leading(scorer, self.scores(base), taken)
        pairs = best_pairs(scorer, base.free_basis, base.residual, entries, price, most)
        known = {term.candidate.key for term in best.terms}
        for pair in pairs:
            if pair.value < self.worth(base) - self.worth(best) + LEAST_MORE:
                break
            if taken | {start.candidate.key for start in pair.starts} == known:
                continue
            rival = self.fitter.solve((*base.terms, *pair.starts), base.frees, base.nuisances)
            best = min(best, rival, key=self.worth)
        return best

    def _free_explains_more(self, solution: Solution) -> bool:
        """Whether one free shape does more than a pile of effects: time to stop piling up."""
        best = max((gain - free_price(free) for free, gain, _ in self.fine_scores(self.empty)),
                   default=0.0)  # fmt: skip
        return self.empty.cost - best < self.worth(solution)

    def _add(self, solution: Solution, other: Solution | None = None) -> Solution | None:
        """With the best further effect; where another story is known, with few or one of that."""
        trials = self.trials(solution)
        if not self.any_shows(trials):
            return None
        strongest = trials[0].gain
        worthy = [t for t in trials[:TRIED] if t.gain > 0.4 * strongest]
        if other is not None:
            told = {term.candidate.key for term in other.terms}
            likely = worthy[:TRIED_OF_RIVALS]
            worthy = [t for t in worthy if t in likely or t.start.candidate.key in told]
        self.progress(f"trying {len(worthy)} explanations")
        tried = self.tried([((*solution.terms, t.start), solution) for t in worthy])
        best = min(self.followed(promising(solution, tried)), key=self.worth)
        return best if self._earns(solution, best, best.terms[-1].candidate) else None

    def group_instead(self, solution: Solution) -> Solution | None:
        """A whole group instead of several effects, where it is the better story."""
        if len(solution.terms) < 2:
            return None
        found = [t for t in self.trials(self.empty, groups=True) if t.start.candidate.members]
        least = 0.3 * (self.empty.cost - solution.cost)

        def grown_from(start: Term) -> Solution:
            rival = self.fitter.solve((start,), (), self.empty.nuisances)
            for left in range(max(len(solution.terms) - 2, 1), 0, -1):
                if self.falls_short(rival, left, self.worth(solution)):
                    break
                grown = self._add(rival, solution)
                if grown is None:
                    break
                rival = self.drop(grown)
            return rival

        starts = [trial.start for trial in found if trial.gain > least]
        rivals = self.fitter.side_by_side([partial(grown_from, start) for start in starts[:2]])
        best = min([solution, *rivals], key=self.worth)
        return None if best is solution else best

    def falls_short(self, rival: Solution, more: int, worth: float) -> bool:
        """Whether a rival stays behind even with all that so many more effects may add to it."""
        gains = sorted((trial.gain for trial in self.trials(rival)), reverse=True)
        return self.worth(rival) - OPTIMISM * sum(gains[:more]) > worth + HOPE

    def one_more(self, solution: Solution, other: Solution) -> Solution:
        """A rival of another solution with a further effect, where one earns its place."""
        grown = self._add(solution, other)
        return solution if grown is None else self.drop(self.swapped(grown))

    def story(self, solution: Solution) -> float:
        """Worth, less what choosing each effect from all of them is worth.

        The price of a free shape has it; a pile of effects in one driver must not get it free.
        """
        return self.worth(solution) + CHOICE * len(solution.terms)
