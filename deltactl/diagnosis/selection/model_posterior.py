"""Which sets of regressors explain a recording, and how probable each is.

Greedy moves with memory (add, drop, swap, pairs from the start), every set by its evidence; the
sets within Occam's window (Madigan and Raftery 1994, J. Am. Stat. Assoc. 89, 1535-1546) make the
posterior: of each effect, of unknown physics, of nothing missing.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.selection.options import SELECTION


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """The sets that count, best first, with their probabilities."""

    explanations: list[Explanation]
    weights: list[float]

    @property
    def best(self) -> Explanation:
        """The most probable set."""
        return self.explanations[0]

    def probability(self, key: str) -> float:
        """That a regressor is at work."""
        pairs = zip(self.explanations, self.weights, strict=True)
        return float(sum(w for e, w in pairs if key in e.keys))

    @property
    def nothing(self) -> float:
        """That no regressor is a finding."""
        pairs = zip(self.explanations, self.weights, strict=True)
        return float(sum(w for e, w in pairs if not e.found))

    def without(self, keys: Iterable[str]) -> float:
        """That none of these is at work."""
        none, pairs = set(keys), zip(self.explanations, self.weights, strict=True)
        return float(sum(w for e, w in pairs if not e.keys & none))


def posterior(explanations: Iterable[Explanation]) -> Posterior:
    """Weights of evaluated sets. Raises OverflowError where none of them has any evidence."""
    return weighed({one: one.log_evidence for one in explanations})


def weighed(evidence: Mapping[Explanation, float]) -> Posterior:
    """Weights by log evidence; of equals the smaller set, then the first, is the best."""
    ordered = sorted(evidence, key=lambda e: (-evidence[e], len(e.keys), sorted(e.keys)))
    top = evidence[ordered[0]]
    if not np.isfinite(top):
        raise OverflowError("no set of regressors has any evidence")
    counted = [e for e in ordered if top - evidence[e] < SELECTION.window]
    weights = np.exp([evidence[e] - top for e in counted])
    return Posterior(counted, (weights / weights.sum()).tolist())


class HillClimb:
    """Climbs the evidence over sets of regressors, one move at a time."""

    def __init__(
        self,
        evidence: Laplace,
        kept: frozenset[str] = frozenset(),
        left_over: bool = False,
        among: Sequence[str] | None = None,
    ):
        """kept: always in the set. left_over: spline terms instead of named regressors. among: only
        these may come and go.
        """
        self.evidence, self.kept = evidence, kept
        self._most: dict[frozenset[str], float] = {}
        chosen = [r for r in evidence.plant.regressors if r.left_over == left_over]
        if among is not None:
            chosen = [r for r in evidence.plant.regressors if r.key in among]
        kept_too = [r for r in evidence.plant.regressors if r.key in kept]
        self._all = {r.key: r for r in (*chosen, *kept_too)}

    def run(self) -> Posterior:
        """From what is kept to where no move is better, with all sets that count there."""
        self.climbed()
        return self.posterior()

    def climbed(
        self, start: frozenset[str] = frozenset(), better_than: float = -np.inf
    ) -> Explanation:
        """From what is kept, and a set to begin with, to where no move is better.

        better_than: log evidence of another plant; nothing is exchanged far below it.
        """
        here = self.evidence(self.kept | start, [self.evidence(self.kept)])
        at_point = self.evidence(self.evidence.plant.point & self._all.keys())
        while (better := self._better(here, better_than - SELECTION.window)) is not None:
            here = better
            if self.evidence.plant.is_far(at_point.beyond_noise, here.beyond_noise):
                break
        return max(self._mine(), key=_order)

    def looked_around(self, here: Explanation) -> None:
        """Know of all sets one move away."""
        self._better(here, -np.inf)

    def posterior(self) -> Posterior:
        """All sets that count; some of them were not evaluated before, for their bound."""
        best = max(self._mine(), key=_order).log_evidence
        for keys, most in self._most.items():
            if most > best - SELECTION.window:
                self.evidence(keys, [self.evidence(self.kept)])
        return posterior(self._mine())

    def _better(self, here: Explanation, least: float) -> Explanation | None:
        """The best set one move away; None where none is better."""
        for way in (lambda e: [*self._moves(e), *self._exchanges(e)], self._smaller):
            best = max(way(here), key=lambda e: e.log_evidence, default=here)
            if best.log_evidence > here.log_evidence + SELECTION.better_by:
                return best
            if here.log_evidence < least:
                return None
        return None

    def _mine(self) -> list[Explanation]:
        """Every set that was evaluated and belongs to this search."""
        return [e for e in self.evidence.evaluated if self.kept <= e.keys <= self._all.keys()]

    def allowed(self, keys: frozenset[str]) -> bool:
        """Whether a set makes sense: what acts beside others has one of them."""
        for key in keys:
            one = self._all[key]
            if one.beside and not keys & set(one.beside):
                return False
        if len(keys - self.evidence.plant.point) > self.evidence.plant.at_once:
            return False
        each = Counter(self._all[key].component for key in keys)
        return max(each.values(), default=0) <= SELECTION.most_regressors

    def _smaller(self, here: Explanation) -> list[Explanation]:
        """Sets that are nearly as good, less one regressor each: one exchanged makes another spare.

        Friction that grows with the load represents friction and an offset.
        """
        close = [
            e for e in self._mine() if here.log_evidence - e.log_evidence < SELECTION.nearly_best
        ]
        sets = {e.keys - {key}: e for e in close for key in e.keys - self.kept}
        return [self.evidence(s, [e]) for s, e in sets.items() if self.allowed(s)]

    def _moves(self, here: Explanation) -> list[Explanation]:
        """All sets with a regressor more, or less, evaluated."""
        keys = here.keys
        others = [r for r in self._all.values() if r.key not in keys]
        sets = [keys | {r.key} for r in others]
        sets += [keys - {key} for key in sorted(keys - self.kept)]
        if len(keys - self.kept) <= SELECTION.pairs_up_to:
            named = [r.key for r in others if r.alone and not r.unknown]
            sets += [keys | set(pair) for pair in itertools.combinations(named, 2)]
        return self._evaluated(here, sets)

    def _exchanges(self, here: Explanation) -> list[Explanation]:
        """All sets with one regressor in place of another, evaluated."""
        keys = here.keys
        others = [r.key for r in self._all.values() if r.key not in keys]
        sets = [(keys - {out}) | {new} for out in sorted(keys - self.kept) for new in others]
        return self._evaluated(here, sets)

    def _evaluated(self, here: Explanation, sets: Iterable[frozenset[str]]) -> list[Explanation]:
        """Those that may be the best, by a bound on their evidence."""
        start = [here, self.evidence(self.kept)]
        most = {s: self.evidence.at_most(s) for s in sets if self.allowed(s)}
        self._most |= most
        found, best = [], here.log_evidence
        for keys in sorted(most, key=lambda s: -most[s]):
            if most[keys] < best:
                break
            found.append(self.evidence(keys, start))
            best = max(best, found[-1].log_evidence)
        return found


def _order(explanation: Explanation) -> tuple[float, int]:
    """The more probable first, and of equals the smaller."""
    return explanation.log_evidence, -len(explanation.keys)
