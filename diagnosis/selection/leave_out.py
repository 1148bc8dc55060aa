"""Leaving out: what each effect of a solution is needed for, and what could stand in its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from diagnosis.answer.verdict import ALARM
from diagnosis.estimation.discrepancy import EXACT, blur_of
from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.penalties import free_price, price_of
from diagnosis.evidence.chi2_tail import log_sf
from diagnosis.observations.readings import FloatArray
from diagnosis.plants.candidate import Candidate, Term
from diagnosis.selection.outside_contact import gain_elsewhere, local_terms
from diagnosis.selection.trials import Trying

TRIED_INSTEAD = 2
BETTER = 1.0
"""What something else must be worth more to take a place."""
CLEARLY = 10.0
"""So many times what a term must gain, and no fit of the others to its end will change it, nor
that another is dropped: what cannot be done without is needed all the more beside fewer others.
"""


@dataclass(frozen=True, slots=True, eq=False)
class Without:
    """The rest of a solution without one of its terms, fitted again."""

    fit: Solution
    needed: bool
    """Whether the term earns its place beside the rest."""
    clearly: bool
    """Whether it does so many times over."""


@dataclass(frozen=True, slots=True, eq=False)
class _Spared:
    """The rest of a solution where it can do without a term."""

    bare: Solution | None
    clearly_needed: bool


@dataclass(slots=True, eq=False)
class LeavingOut(Trying):
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
            with self.patience.not_counted():
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
            with self.patience.not_counted():
                found = self.fitter.side_by_side(
                    [partial(self._left, solution, k) for k in numbers]
                )
            self.remember(solution, found)
        assert self._last is not None
        return self._last[1]

    def remember(self, solution: Solution, found: list[Without]) -> None:
        """A solution that was looked at without each of its terms."""
        self._last = solution, [replace(one, fit=one.fit.without_tangent()) for one in found]

    def _left(self, solution: Solution, number: int) -> Without:
        begun = self._begun_without(solution, number)
        clearly = self._clearly_needed(solution, number, begun)
        return self._refitted(solution, number, begun, clearly)

    def _refitted(self, solution: Solution, number: int, begun: Solution, clearly: bool) -> Without:
        """The rest without a term brought to its end; clearly: whether that was seen before."""
        known = _others(solution, number)
        fit = self.fitter.solve(begun.terms, begun.frees, begun.nuisances, known=known)
        new = solution.terms[number].candidate
        clearly = clearly or self._clearly(fit, solution, new)
        return Without(fit, clearly or self._earns(fit, solution, new), clearly)

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
        return self.p(log_sf(gain, len(new.moved))) <= ALARM

    def drop(
        self,
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
            return solution if solution.cost < before.cost - BETTER else before
        if self._last is not None and self._last[0] is solution:
            found = [_Spared(None if one.needed else one.fit, one.clearly) for one in self._last[1]]
        else:
            found = self._spared(solution, before, sure)
        bare = first_of([one.bare for one in found])
        if bare is None:
            return solution
        keys = [term.candidate.key for term in solution.terms]
        more = [key for key, one in zip(keys, found, strict=True) if one.clearly_needed]
        return self.drop(bare, before, sure.union(more))

    def _spared(
        self, solution: Solution, before: Solution | None, sure: frozenset[tuple[str, ...]]
    ) -> list[_Spared]:
        """The rest without each term that does not earn its place; first what one has more."""
        count = len(solution.terms)
        found = [_Spared(None, True)] * count
        asked = [k for k in range(count) if solution.terms[k].candidate.key not in sure]
        more = [] if before is None else _only_in(solution, before)
        if len(more) == 1:
            found[more[0]] = self._spare(solution, more[0])
            if found[more[0]].bare is not None:
                return [one if k in more else _Spared(None, False) for k, one in enumerate(found)]
            asked = [k for k in asked if k not in more]
        tasks = [partial(self._spare, solution, k) for k in asked]
        for k, one in zip(asked, self.fitter.side_by_side(tasks), strict=True):
            found[k] = one
        return found

    def _spare(self, solution: Solution, number: int) -> _Spared:
        """The rest without a term that does not earn its place."""
        begun = self._begun_without(solution, number)
        if self._clearly_needed(solution, number, begun):
            return _Spared(None, True)
        left = self._refitted(solution, number, begun, False)
        return _Spared(None if left.needed else left.fit, left.clearly)

    def _begun_without(self, solution: Solution, number: int) -> Solution:
        """The first step in which the others make up for a term."""
        rest = without(solution.terms, number)
        known = _others(solution, number)
        return self.fitter.solve(rest, solution.frees, solution.nuisances, 1, known)

    def _clearly_needed(self, solution: Solution, number: int, begun: Solution) -> bool:
        """Whether the others leave far too much after a step that they could take."""
        if not self._clearly(begun, solution, solution.terms[number].candidate):
            return False
        rest = without(solution.terms, number)
        before = self.fitter.solve(rest, solution.frees, solution.nuisances, 0)
        return begun.cost < before.cost

    def _clearly(self, without: Solution, found: Solution, new: Candidate) -> bool:
        """Whether an effect gains many times enough."""
        gain = (without.cost - found.cost) / CLEARLY
        return self._shows(gain, new) and gain >= self.least_gain(without, new)

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
        own, gain = solution.terms[number].candidate.key, bare.cost - solution.cost
        for trial in self.trials(bare, [own])[:TRIED_INSTEAD]:
            if trial.gain < 0.8 * gain:
                continue
            tried = self.begun((*bare.terms, trial.start), bare)
            if not tried.within_reach(solution, gain):
                continue
            other = self.follow(tried)
            if self.worth(other) < self.worth(solution) - BETTER:
                return other
        return None


def first_of(found: Sequence[Solution | None]) -> Solution | None:
    """The first solution among them."""
    return next((one for one in found if one is not None), None)


def _others(solution: Solution, number: int) -> FloatArray:
    """The tangent less what belongs to one term or to free shapes, (m, p)."""
    return np.delete(solution.named_tangent, solution.columns_of(number), axis=1)


def _same_terms(one: Solution, other: Solution) -> bool:
    same = len(one.terms) == len(other.terms) and one.frees == other.frees
    return same and not _only_in(one, other)


def _only_in(one: Solution, other: Solution) -> list[int]:
    """Numbers of the terms that another solution does not have."""
    known = {term.candidate.key for term in other.terms}
    return [k for k, term in enumerate(one.terms) if term.candidate.key not in known]


def without(terms: Sequence[Term], number: int) -> tuple[Term, ...]:
    """Terms less one."""
    return (*terms[:number], *terms[number + 1 :])
