"""How probable each finding is, each of its rivals, unknown physics, and that nothing is missing.

The sets that were compared around the chosen one (a finding left out, a rival in its place) are
weighed by their evidence: Occam's window (Madigan and Raftery 1994, J. Am. Stat. Assoc. 89,
1535-1546). Where nothing was found it is the chosen set, and every test of the library is a rival.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.splines import SplineTerm
from diagnosis.evidence.detection import Detection
from diagnosis.observations.readings import FloatArray
from diagnosis.priors.penalties import spline_penalty
from diagnosis.priors.size_priors import covariance_of, odds_cost, score_log_odds, size_cost
from diagnosis.score_tests.library import Entry
from diagnosis.search.search import Search
from diagnosis.selection.ambiguity import Standing

Name = tuple[str, str]
"""Effect and component."""
LAPSE = 0.02
"""Chance that the search ended at a wrong set and nothing it compared around that shows it. Of 111
claims that the comparison alone made with more than 0.95, on proof cases of two old seeds, three
were wrong."""
FACTOR = 3.0
"""To which priors of size are known."""
MOST = 700.0
"""Exponents beyond which a weight is as good as nothing or everything."""


@dataclass(frozen=True, slots=True, eq=False)
class Credible:
    """Probabilities of one settled explanation."""

    terms: list[float]
    """Of each term of the solution, in their order."""
    rivals: list[dict[Name, float]]
    """For each term: of what may act in its place."""
    shapes: list[float]
    """Of each spline term: that something outside the vocabulary acts."""
    nothing: float
    preferred: Solution | None = None
    """A rival that is far more probable than the finding in whose place it stands."""
    under: list[tuple[float, float]] = field(default_factory=list)
    """Of each term, with all priors three times narrower and three times wider."""


def credible(search: Search, solution: Solution, stands: Sequence[Standing]) -> Credible:
    """Weigh what the search compared around its solution."""
    weighing = _Weighing(solution, stands)
    least = search.options.preferred
    better: list[tuple[float, Solution]] = []
    terms: list[float] = []
    rivals: list[dict[Name, float]] = []
    for number, stand in enumerate(stands):
        weights = weighing.of_rivals(number)
        pairs = list(zip(stand.rivals, weights, strict=True))
        better += [(weight, rival) for rival, weight in pairs if weight > least]
        total = weighing.total(number)
        terms.append((1.0 - LAPSE) / total)
        rivals.append(_by_name(solution, [(one, weight / total) for one, weight in pairs]))
    others = [_Weighing(solution, stands, weighing.known, f) for f in (1.0 / FACTOR, FACTOR)]
    shapes = [_of_shape(search, solution, free) for free in solution.frees]
    nothing = _nothing(search.tests, solution, sum(weighing.costs))
    return Credible(
        terms=terms,
        rivals=rivals,
        shapes=shapes,
        # Where nothing is missing, no term is there: three arms that err alike are one cause.
        nothing=min([nothing, *weighing.absent, *(1.0 - p for p in shapes)]),
        preferred=max(better, key=lambda pair: pair[0])[1] if better else None,
        under=[
            ((1.0 - LAPSE) / others[0].total(k), (1.0 - LAPSE) / others[1].total(k))
            for k in range(len(stands))
        ],
    )


class _Weighing:
    """Weights of what was compared around a solution, relative to it."""

    def __init__(
        self,
        solution: Solution,
        stands: Sequence[Standing],
        known: dict[int, FloatArray] | None = None,
        factor: float = 1.0,
    ):
        """factor: by which all priors are wider. known: covariances by id of their solution."""
        self.solution, self.stands, self.factor = solution, stands, factor
        self.known = {} if known is None else known
        self.costs = [self._cost(solution, k) for k in range(len(solution.terms))]

    def total(self, number: int) -> float:
        """Weights of a term, its rivals and nothing in its place; its own is 1."""
        return 1.0 + self._none(number) + sum(self.of_rivals(number))

    @property
    def absent(self) -> list[float]:
        """Probability of each term that nothing stands in its place."""
        return [self._none(k) / self.total(k) for k in range(len(self.stands))]

    def _none(self, number: int) -> float:
        return _weight(self.stands[number].gain - self.costs[number])

    def of_rivals(self, number: int) -> list[float]:
        """Of everything that may stand in a term's place."""
        return [_weight(self._behind(rival)) for rival in self.stands[number].rivals]

    def _cost(self, solution: Solution, number: int) -> float:
        """-2 log prior, odds and Occam factor of one term."""
        if id(solution) not in self.known:
            self.known[id(solution)] = covariance_of(solution)
        own = size_cost(solution, number, self.known[id(solution)], self.factor)
        return own + odds_cost(solution.terms[number].candidate)

    def _behind(self, rival: Solution) -> float:
        """By how much the -2 log evidence of a rival is larger."""
        own = {term.candidate.key for term in self.solution.terms}
        others = {term.candidate.key for term in rival.terms}
        terms = enumerate(self.solution.terms)
        more = [self._cost(rival, k) for k, t in enumerate(rival.terms)
                if t.candidate.key not in own]  # fmt: skip
        less = [self.costs[k] for k, t in terms if t.candidate.key not in others]
        return rival.cost - self.solution.cost + sum(more) - sum(less)


def _weight(behind: float) -> float:
    """Of an explanation whose -2 log evidence is so much larger than the chosen one's."""
    return math.exp(min(max(-0.5 * behind, -MOST), MOST))


def _by_name(solution: Solution, weighed: Sequence[tuple[Solution, float]]) -> dict[Name, float]:
    """Probability of each effect and component that stands in rivals and not in the solution."""
    own = {term.candidate.key for term in solution.terms}
    found: dict[Name, float] = {}
    for rival, weight in weighed:
        for term in rival.terms:
            if term.candidate.key in own:
                continue
            for component in term.candidate.members or (term.candidate.component,):
                name = (term.candidate.effect, component)
                found[name] = found.get(name, 0.0) + weight
    return found


def _of_shape(search: Search, solution: Solution, free: SplineTerm) -> float:
    """Of a spline term: against nothing, and against the best named effect in its place."""
    others = tuple(one for one in solution.frees if one is not free)
    bare = search.fitter.solve(solution.terms, others, solution.nuisances, steps=2)
    cost = spline_penalty(free)
    weights = [_weight(bare.cost - solution.cost - cost)]
    for trial in search.tests.trials(bare)[:1]:
        behind = bare.cost - trial.gain + trial.penalty + search.options.choice
        weights.append(_weight(behind - solution.cost - cost))
    return (1.0 - LAPSE) / (1.0 + sum(weights))


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
    scores = tests.scores(tests.empty)
    found: dict[tuple[str, ...], list[float]] = {}
    for number, entry in enumerate(tests.prepared.library.entries):
        gain = float(scores.gain[number] / tests.prepared.scorer.tolerance_factor[number])
        log_odds = _entry_log_odds(entry, gain, scores.step[number], scores.information[number])
        found.setdefault(entry.key, []).append(math.exp(min(log_odds, MOST)))
    for free, gain, _ in tests.fine_scores(tests.empty):
        log_odds = 0.5 * (gain - spline_penalty(free))
        found[("fine", free.location, free.covariate)] = [math.exp(min(log_odds, MOST))]
    return [float(np.mean(one)) for one in found.values()]


def _entry_log_odds(entry: Entry, gain: float, step: FloatArray, information: FloatArray) -> float:
    if entry.candidate is None:
        assert entry.free is not None
        return 0.5 * (gain - spline_penalty(entry.free))
    assert entry.shape is not None
    raw = float(step @ information @ step)
    counted = gain / raw if raw > 0.0 else 1.0
    return score_log_odds(entry.candidate, entry.shape.linear, step, counted * information)
