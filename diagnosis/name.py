"""Naming: add the best effect, refit all, swap, drop, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

from diagnosis.blur import EXACT, blur_of
from diagnosis.candidate import Candidate, Term
from diagnosis.chance import log_sf
from diagnosis.detect import ALPHA, Detection
from diagnosis.elsewhere import gain_elsewhere, local_terms
from diagnosis.free_shapes import FreeShape
from diagnosis.pairs import best_pairs, leading
from diagnosis.prices import free_price, price, price_of
from diagnosis.solution import Solution

CHOICE = 12.0
"""Chi-square that choosing one of a hundred candidates is worth."""
TRIED = 6
TRIED_OF_RIVALS = 2
QUICK = 2
"""Steps of a first try."""
HOPEFUL, HOPE = 0.7, 40.0
"""Share of the best first try's gain, and chi-square behind it, with which a fit is followed."""
OPTIMISM = 1.5
"""How much more than its linearised gain an effect may bring."""
TRIED_PAIRS = 3
LEAST_MORE = 5.0
"""What two others must promise beyond the newest two for a refit to be worth its time."""
MOST_TERMS = 5
PILE = 3
"""So many effects may be a pile that stands for one cause in no list."""
MOST_TURNS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Tried:
    """What is kept of a fit that was only begun."""

    terms: tuple[Term, ...]
    nuisances: tuple[Term, ...]
    frees: tuple[FreeShape, ...]
    cost: float


@dataclass(slots=True, eq=False)
class Search(Detection):
    """The search for the set of effects that explains a recording."""

    _parts: dict[tuple[tuple[str, ...], ...], float] = field(default_factory=dict)

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

    def run(self) -> Solution:
        """The best set of named effects, one after the other."""
        return self._collected(self.empty)

    def finished(self, solution: Solution) -> Solution:
        """The same, less what only came before others did."""
        if len(solution.terms) >= PILE and self._free_explains_more(solution):
            return solution
        split = self.split(solution)
        return solution if split is solution else self.drop(split)

    def resumed(self, found: Solution) -> Solution:
        """The same, from a set that was found under other noise."""
        return self._collected(self.drop(self.fitter.solve(found.terms, (), found.nuisances)))

    def _collected(self, solution: Solution) -> Solution:
        for _ in range(MOST_TURNS):
            if len(solution.terms) >= PILE and self._free_explains_more(solution):
                return solution
            grown = self._add(solution) if len(solution.terms) < MOST_TERMS else None
            if grown is None:
                break
            grown = self._paired(solution, grown)
            solution = self.drop(self._swap(grown))
        return solution

    def _paired(self, before: Solution, grown: Solution) -> Solution:
        """Two others in place of the newest two, where these together would do more."""
        if not before.terms:
            return grown
        base = self.empty
        if len(before.terms) > 1:
            base = self.fitter.solve(before.terms[:-1], before.frees, before.nuisances, steps=4)
        return self._with_pair(base, grown, TRIED_PAIRS)

    def split(self, solution: Solution) -> Solution:
        """Two causes in place of one that looks like both beside the others."""

        def in_place_of(number: int) -> Solution:
            rest = _without(solution.terms, number)
            base = self.fitter.solve(rest, solution.frees, solution.nuisances, steps=4)
            return self._with_pair(base, solution, 1)

        numbers = range(len(solution.terms) if 1 < len(solution.terms) < MOST_TERMS else 0)
        others = self.fitter.side_by_side([partial(in_place_of, number) for number in numbers])
        return min([solution, *others], key=self.worth)

    def _with_pair(self, base: Solution, best: Solution, most: int) -> Solution:
        """The best so far, or a base with the two that do more together."""
        scorer, taken = self.prepared.scorer, {term.candidate.key for term in base.terms}
        entries = leading(scorer, self.scores(base), taken)
        pairs = best_pairs(scorer, base.free_tangent, base.residual, entries, price, most)
        for pair in pairs:
            if pair.value < self.worth(base) - self.worth(best) + LEAST_MORE:
                break
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
        if not trials or self.p(min(t.log_p for t in trials)) > ALPHA:
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

    def _earns(self, without: Solution, found: Solution, new: Candidate) -> bool:
        """Whether an effect gains enough, everywhere or at least where nothing local blurs it."""
        gain = without.cost - found.cost
        if self.p(log_sf(gain, len(new.moved))) > ALPHA:
            return False
        if gain >= self.least_gain(without, new):
            return True
        local = local_terms(without.terms)
        if not local or gain < self.least_gain(without, new, local):
            return False
        gain = gain_elsewhere(self.fitter, without, found) / self.doubt_of(new)
        return self.p(log_sf(gain, len(new.moved))) <= ALPHA

    def tried(self, rivals: Sequence[tuple[tuple[Term, ...], Solution]]) -> list[Tried]:
        """Fits of terms that are only begun, with the rest from where another solution has it."""
        return self.fitter.side_by_side([partial(self._begun, *rival) for rival in rivals])

    def _begun(self, terms: tuple[Term, ...], beside: Solution) -> Tried:
        known = beside.tangent[:, : beside.tangent.shape[1] - len(beside.coefficients)]
        one = self.fitter.solve(terms, beside.frees, beside.nuisances, QUICK, known)
        return Tried(one.terms, one.nuisances, one.frees, one.cost)

    def followed(self, tried: Sequence[Tried]) -> list[Solution]:
        """Fits that were begun, brought to their end."""
        return self.fitter.side_by_side(
            [partial(self.fitter.solve, one.terms, one.frees, one.nuisances) for one in tried]
        )

    def _swap(self, solution: Solution) -> Solution:
        """Try to replace each term but the newest by something better."""
        numbers = range(len(solution.terms) - 1)
        swapped = self.fitter.side_by_side([partial(self._other, solution, k) for k in numbers])
        return next((other for other in swapped if other is not None), solution)

    def _other(self, solution: Solution, number: int) -> Solution | None:
        """Something better in place of one term."""
        rest = _without(solution.terms, number)
        bare = self.fitter.solve(rest, solution.frees, solution.nuisances, steps=4)
        own = solution.terms[number].candidate.key
        for trial in self.trials(bare, [own])[:2]:
            if trial.gain < 0.8 * (bare.cost - solution.cost):
                continue
            other = self.fitter.solve((*rest, trial.start), solution.frees, bare.nuisances)
            if self.worth(other) < self.worth(solution) - 1.0:
                return other
        return None

    def drop(self, solution: Solution) -> Solution:
        """Leave out whatever no longer earns its place."""
        if len(solution.terms) + len(solution.frees) == 1:
            return solution
        numbers = range(len(solution.terms))
        bared = self.fitter.side_by_side([partial(self._useless, solution, k) for k in numbers])
        return next((self.drop(bare) for bare in bared if bare is not None), solution)

    def _useless(self, solution: Solution, number: int) -> Solution | None:
        """The solution without a term that does not earn its place."""
        rest = _without(solution.terms, number)
        bare = self.fitter.solve(rest, solution.frees, solution.nuisances)
        new = solution.terms[number].candidate
        return None if self._earns(bare, solution, new) else bare

    def with_group(self, solution: Solution) -> Solution:
        """A whole group instead of several effects, where it is the better story."""
        if len(solution.terms) < 2:
            return solution
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
        return min([solution, *rivals], key=self.worth)

    def falls_short(self, rival: Solution, more: int, worth: float) -> bool:
        """Whether a rival stays behind even with all that so many more effects may add to it."""
        gains = sorted((trial.gain for trial in self.trials(rival)), reverse=True)
        return self.worth(rival) - OPTIMISM * sum(gains[:more]) > worth + HOPE

    def one_more(self, solution: Solution, other: Solution) -> Solution:
        """A rival of another solution with a further effect, where one earns its place."""
        grown = self._add(solution, other)
        return solution if grown is None else self.drop(self._swap(grown))

    def story(self, solution: Solution) -> float:
        """Worth, less what choosing each effect from all of them is worth.

        The price of a free shape has it; a pile of effects in one driver must not get it free.
        """
        return self.worth(solution) + CHOICE * len(solution.terms)


def promising(before: Solution, tried: Sequence[Tried]) -> list[Tried]:
    """Fits that may yet become the best of those that were begun."""
    most = max((before.cost - one.cost for one in tried), default=0.0)
    least = min(HOPEFUL * most, most - HOPE)
    return [one for one in tried if before.cost - one.cost >= least]


def _without(terms: Sequence[Term], number: int) -> tuple[Term, ...]:
    return (*terms[:number], *terms[number + 1 :])
