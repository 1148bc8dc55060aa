"""Probabilities of each finding, of its alternatives, of unknown physics, and of nothing missing.

The sets that were compared around the chosen one (a finding left out, an alternative in its place)
are weighed by their evidence: Occam's window (Madigan and Raftery 1994, J. Am. Stat. Assoc. 89,
1535-1546). Where nothing was found it is the chosen set, and every test of the library is an
alternative.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.splines import SplineTerm
from deltactl.diagnosis.evidence.detection import Detection
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.priors.options import SIZE_PRIORS
from deltactl.diagnosis.priors.penalties import spline_penalty
from deltactl.diagnosis.priors.size_priors import odds_cost, score_log_odds, size_cost
from deltactl.diagnosis.score_tests.library import Entry
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.ambiguity import Standing
from deltactl.diagnosis.selection.imitation import Beside, beside_unknown
from deltactl.diagnosis.selection.nonparametric import InPlace, in_place_of
from deltactl.diagnosis.selection.options import CREDIBLE

Name = tuple[str, str]
"""Effect and component."""
MOST = 700.0
"""Exponents beyond which a weight is as good as nothing or everything."""


@dataclass(frozen=True, slots=True, eq=False)
class Credible:
    """Probabilities of one settled explanation."""

    terms: list[float]
    """Probability of each term of the solution, in their order."""
    alternatives: list[dict[Name, float]]
    """For each term: of what may act in its place."""
    shapes: list[float]
    """Probability of each spline term: that something outside the vocabulary acts."""
    nothing: float
    beside: list[Beside]
    """For each term: whether it may only imitate something unknown."""
    under: list[tuple[float, float]]
    """Probabilities of each term, with all priors of size narrower and wider by as much as they are
    known to."""


def preferred(search: Search, solution: Solution, stands: Sequence[Standing]) -> Solution | None:
    """The alternative that is far more probable than the finding that it replaces, if any."""
    weights = _weigh(search, solution, stands)
    pairs = [
        pair
        for stand, each in zip(stands, weights.alternatives, strict=True)
        for pair in zip(each, stand.refits, strict=True)
    ]
    weight, alternative = max(pairs, key=lambda pair: pair[0], default=(0.0, solution))
    return alternative if weight > search.options.preferred else None


def credible(
    search: Search,
    solution: Solution,
    stands: Sequence[Standing],
    in_place: Mapping[SplineTerm, InPlace] | None = None,
) -> Credible:
    """Weigh what the search compared around its solution.

    in_place: what is known of this solution without its spline terms; the rest is fitted here.
    """
    weights = _weigh(search, solution, stands)
    narrower = _weigh(search, solution, stands, 1.0 / SIZE_PRIORS.known_to)
    wider = _weigh(search, solution, stands, SIZE_PRIORS.known_to)
    alternatives = []
    beside = beside_unknown(search.fitter, solution)
    own = [one.own for one in beside]
    for stand, each, total, one in zip(
        stands, weights.alternatives, weights.totals, own, strict=True
    ):
        chances = [one * weight / total for weight in each]
        alternatives.append(_by_name(solution, list(zip(stand.refits, chances, strict=True))))
    known = in_place or {}
    instead = [known.get(free) or in_place_of(search, solution, free) for free in solution.frees]
    shapes = [
        _of_shape(search, solution, *pair) for pair in zip(solution.frees, instead, strict=True)
    ]
    nothing = _nothing(search.tests, solution, sum(weights.costs))
    return Credible(
        terms=weights.of_terms(own),
        alternatives=alternatives,
        shapes=shapes,
        # Where nothing is missing, no term is there: three arms that err alike are one cause.
        nothing=min([nothing, *weights.absent(), *(1.0 - p for p in shapes)]),
        beside=beside,
        under=list(zip(narrower.of_terms(own), wider.of_terms(own), strict=True)),
    )


@dataclass(frozen=True, slots=True)
class _Weights:
    """Weights of what was compared around a solution, relative to it, by its terms."""

    costs: list[float]
    """-2 log of each term's prior odds and Occam factor."""
    alternatives: list[list[float]]
    """Weights of everything that may be in a term's place."""
    none: list[float]
    """Weights of nothing in its place."""

    @property
    def totals(self) -> list[float]:
        """Total weight of a term, whose own weight is 1, its alternatives and nothing in its
        place."""
        pairs = zip(self.alternatives, self.none, strict=True)
        return [1.0 + none + sum(alternatives) for alternatives, none in pairs]

    def of_terms(self, own: Sequence[float]) -> list[float]:
        """Probability of each term. own: that it is no imitation of something unknown."""
        pairs = zip(own, self.totals, strict=True)
        return [one * (1.0 - CREDIBLE.lapse) / total for one, total in pairs]

    def absent(self) -> list[float]:
        """Probability of each term that nothing is in its place."""
        return [none / total for none, total in zip(self.none, self.totals, strict=True)]


def _weigh(
    search: Search, solution: Solution, stands: Sequence[Standing], factor: float = 1
) -> _Weights:
    """factor: by which all priors are wider."""
    left = search.tests.left_by_measured

    def cost(fit: Solution, number: int, share: float) -> float:
        own = fit.terms[number].candidate
        return size_cost(fit, number, factor) + odds_cost(own) + share * left.charge(own)

    shares = _shares(solution, stands)
    costs = [cost(solution, number, share) for number, share in enumerate(shares)]
    own = [term.candidate.key for term in solution.terms]

    def behind(alternative: Solution, share: float) -> float:
        """By how much the -2 log evidence of an alternative is larger."""
        others = [term.candidate.key for term in alternative.terms]
        more = sum(cost(alternative, k, share) for k, key in enumerate(others) if key not in own)
        less = sum(c for key, c in zip(own, costs, strict=True) if key not in others)
        return alternative.cost - solution.cost + more - less

    alternatives = [
        [_weight(behind(alternative, share)) for alternative in stand.refits]
        for stand, share in zip(stands, shares, strict=True)
    ]
    none = [_weight(stand.gain - c) for stand, c in zip(stands, costs, strict=True)]
    return _Weights(costs, alternatives, none)


def _shares(solution: Solution, stands: Sequence[Standing]) -> list[float]:
    """The share of what measured effects may leave that each term has to exceed.

    They leave it once: of joints that err alike, found together, each bears what it explains.
    """
    gains = [max(stand.gain, 0.0) for stand in stands]
    effects = [term.candidate.effect for term in solution.terms]
    together = {
        effect: sum(gain for one, gain in zip(effects, gains, strict=True) if one == effect)
        for effect in effects
    }
    pairs = zip(effects, gains, strict=True)
    return [gain / together[effect] if together[effect] else 1.0 for effect, gain in pairs]


def _weight(behind: float) -> float:
    """Weight of an explanation whose -2 log evidence is so much larger than the chosen one's."""
    return math.exp(min(max(-0.5 * behind, -MOST), MOST))


def _by_name(solution: Solution, weighed: Sequence[tuple[Solution, float]]) -> dict[Name, float]:
    """Probability of each effect and component that is in alternatives and not in the solution."""
    own = {term.candidate.key for term in solution.terms}
    found: dict[Name, float] = {}
    for alternative, weight in weighed:
        for term in alternative.terms:
            if term.candidate.key in own:
                continue
            for component in term.candidate.members or (term.candidate.component,):
                name = (term.candidate.effect, component)
                found[name] = found.get(name, 0.0) + weight
    return found


def _of_shape(search: Search, solution: Solution, free: SplineTerm, instead: InPlace) -> float:
    """Weight of a spline term: against nothing, and against the best named effect in its place."""
    weights = [_weight(instead.bare.cost - solution.cost - spline_penalty(free))]
    if instead.named is not None:
        cost = search.criterion.fully_penalised
        weights.append(_weight(cost(instead.named) - cost(solution)))
    return (1.0 - CREDIBLE.lapse) / (1.0 + sum(weights))


def _nothing(tests: Detection, solution: Solution, cost: float) -> float:
    """That no effect is at work."""
    if solution.terms or solution.frees:
        cost += sum(spline_penalty(free) for free in solution.frees)
        weight = _weight(tests.empty.cost - solution.cost - cost)
        return weight / (1.0 + weight)
    return 1.0 / (1.0 + sum(odds_against_nothing(tests)))


def odds_against_nothing(tests: Detection) -> list[float]:
    """Posterior odds of each candidate and each spline term against the empty set, linearised.

    A candidate with several starting points has the mean over them: they are its prior.
    """
    scores, scorer = tests.scores(tests.empty), tests.prepared.scorer
    found: dict[tuple[str, ...], list[float]] = {}
    for number, entry in enumerate(tests.prepared.library.entries):
        beyond = max(scores.gain[number] - scorer.left_by_measured[number], 0.0)
        gain = float(beyond / scorer.tolerance_factor[number])
        log_odds = _entry_log_odds(entry, gain, scores.step[number], scores.information[number])
        found.setdefault(entry.key, []).append(math.exp(min(log_odds, MOST)))
    for free, gain, _ in tests.fine_scores(tests.empty):
        log_odds = _spline_log_odds(free, max(gain - tests.left_by_measured.of(), 0.0))
        found[("fine", free.location, free.covariate)] = [math.exp(min(log_odds, MOST))]
    return [float(np.mean(one)) for one in found.values()]


def _entry_log_odds(entry: Entry, gain: float, step: FloatArray, information: FloatArray) -> float:
    if entry.candidate is None:
        assert entry.free is not None
        return _spline_log_odds(entry.free, gain)
    assert entry.shape is not None
    raw = float(step @ information @ step)
    counted = gain / raw if raw > 0.0 else 1.0
    return score_log_odds(entry.candidate, entry.shape.linear, step, counted * information)


def _spline_log_odds(free: SplineTerm, gain: float) -> float:
    return 0.5 * (gain - spline_penalty(free))
