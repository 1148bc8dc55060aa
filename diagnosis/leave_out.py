"""Leaving out: what each effect of a solution is needed for, and what could stand in its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from diagnosis.blur import EXACT, blur_of
from diagnosis.candidate import Candidate, Term
from diagnosis.chance import log_sf
from diagnosis.detect import ALPHA, Detection
from diagnosis.elsewhere import gain_elsewhere, local_terms
from diagnosis.prices import free_price, price_of
from diagnosis.solution import Solution

TRIED_INSTEAD = 2
CLEARLY = 10.0
"""So many times what a term must gain, and no fit of the others to its end will change it."""


@dataclass(frozen=True, slots=True, eq=False)
class Without:
    """The rest of a solution without one of its terms, fitted again."""

    fit: Solution
    needed: bool
    """Whether the term earns its place beside the rest."""


@dataclass(slots=True, eq=False)
class LeavingOut(Detection):
    """Solutions less one of their terms, and less what no longer earns its place."""

    _parts: dict[tuple[tuple[str, ...], ...], float] = field(default_factory=dict)
    _last: tuple[Solution, list[Without]] | None = None
    """The solution that was last looked at without each of its terms; one, for it is large."""

    def least_gain(
        self, solution: Solution, new: Candidate | None = None, exact: Sequence[Term] = ()
    ) -> float:
        """What a new effect must explain at least: a share of what is explained already.

        Sharp effects count first, so that what two could explain is not charged as blur.
        exact: terms that leave nothing in the readings that are looked at.
        """
        least, before = 0.0, self.empty.cost
        blur = [EXACT if term in exact else blur_of(term, new) for term in solution.terms]
        for share in sorted(set(blur)):
            part = tuple(t for t, own in zip(solution.terms, blur, strict=True) if own <= share)
            whole = part == solution.terms and not solution.frees
            now = solution.cost if whole else self._part(part)
            least, before = least + share * max(before - now, 0.0), min(now, before)
        return least + EXACT * max(before - solution.cost, 0.0)

    def _part(self, terms: tuple[Term, ...]) -> float:
        """Cost with some of the terms alone."""
        key = tuple(term.candidate.key for term in terms)
        if key not in self._parts:
            self._parts[key] = self.fitter.solve(terms, (), self.empty.nuisances, 2).cost
        return self._parts[key]

    def worth(self, solution: Solution) -> float:
        """Cost with the price of everything in it: the smaller the better."""
        prices = sum(price_of(term) for term in solution.terms)
        return solution.cost + prices + sum(free_price(free) for free in solution.frees)

    def without(self, solution: Solution) -> list[Without]:
        """It without each of its terms in turn."""
        if self._last is None or self._last[0] is not solution:
            numbers = range(len(solution.terms))
            found = self.fitter.side_by_side([partial(self._left, solution, k) for k in numbers])
            self.remember(solution, found)
        assert self._last is not None
        return self._last[1]

    def remember(self, solution: Solution, found: list[Without]) -> None:
        """A solution that was looked at without each of its terms."""
        self._last = solution, [Without(one.fit.without_tangent(), one.needed) for one in found]

    def _left(self, solution: Solution, number: int, begun: Solution | None = None) -> Without:
        begun = self._begun_without(solution, number) if begun is None else begun
        fit = self.fitter.solve(begun.terms, begun.frees, begun.nuisances)
        needed = self._clearly_needed(solution, number, begun)
        return Without(fit, needed or self._earns(fit, solution, solution.terms[number].candidate))

    def _earns(self, without: Solution, found: Solution, new: Candidate) -> bool:
        """Whether an effect gains enough, everywhere or at least where nothing local blurs it."""
        gain = without.cost - found.cost
        if not self._shows(gain, new):
            return False
        if gain >= self.least_gain(without, new):
            return True
        local = local_terms(without.terms)
        if not local or gain < self.least_gain(without, new, local):
            return False
        gain = gain_elsewhere(self.fitter, without, found) / self.doubt_of(new)
        return self._shows(gain, new)

    def _shows(self, gain: float, new: Candidate) -> bool:
        """Whether a gain in chi-square is more than chance."""
        return self.p(log_sf(gain, len(new.moved))) <= ALPHA

    def drop(self, solution: Solution) -> Solution:
        """Leave out whatever no longer earns its place."""
        if len(solution.terms) + len(solution.frees) == 1:
            return solution
        if self._last is not None and self._last[0] is solution:
            found = [None if one.needed else one.fit for one in self._last[1]]
        else:
            numbers = range(len(solution.terms))
            found = self.fitter.side_by_side([partial(self._spare, solution, k) for k in numbers])
        bare = first_of(found)
        return solution if bare is None else self.drop(bare)

    def _spare(self, solution: Solution, number: int) -> Solution | None:
        """The rest without a term that does not earn its place."""
        begun = self._begun_without(solution, number)
        if self._clearly_needed(solution, number, begun):
            return None
        left = self._left(solution, number, begun)
        return None if left.needed else left.fit

    def _begun_without(self, solution: Solution, number: int) -> Solution:
        """The first step in which the others make up for a term."""
        rest = without(solution.terms, number)
        known = np.delete(solution.named_tangent, solution.columns_of(number), axis=1)
        return self.fitter.solve(rest, solution.frees, solution.nuisances, 1, known)

    def _clearly_needed(self, solution: Solution, number: int, begun: Solution) -> bool:
        """Whether the others leave far too much after a step that they could take."""
        new, gain = solution.terms[number].candidate, (begun.cost - solution.cost) / CLEARLY
        if not self._shows(gain, new) or gain < self.least_gain(begun, new):
            return False
        rest = without(solution.terms, number)
        before = self.fitter.solve(rest, solution.frees, solution.nuisances, 0)
        return begun.cost < before.cost

    def swapped(self, solution: Solution) -> Solution:
        """With something better in the place of a term other than the newest."""
        tasks = [
            partial(self._other, solution, number, one.fit)
            for number, one in enumerate(self.without(solution)[:-1])
        ]
        return first_of(self.fitter.side_by_side(tasks)) or solution

    def reconsidered(self, solution: Solution, number: int) -> tuple[Without, Solution | None]:
        """It without a term, and with something better in place of one other than the newest."""
        bare = self._left(solution, number)
        newest = number == len(solution.terms) - 1
        return bare, None if newest else self._other(solution, number, bare.fit)

    def _other(self, solution: Solution, number: int, bare: Solution) -> Solution | None:
        """Something better in place of one term, without which `bare` is left."""
        own = solution.terms[number].candidate.key
        for trial in self.trials(bare, [own])[:TRIED_INSTEAD]:
            if trial.gain < 0.8 * (bare.cost - solution.cost):
                continue
            terms = (*without(solution.terms, number), trial.start)
            other = self.fitter.solve(terms, solution.frees, bare.nuisances)
            if self.worth(other) < self.worth(solution) - 1.0:
                return other
        return None


def first_of(found: Sequence[Solution | None]) -> Solution | None:
    """The first solution among them."""
    return next((one for one in found if one is not None), None)


def without(terms: Sequence[Term], number: int) -> tuple[Term, ...]:
    """Terms less one."""
    return (*terms[:number], *terms[number + 1 :])
