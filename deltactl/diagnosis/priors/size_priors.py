"""What an effect costs in evidence: prior odds, the prior of its size, and its Occam factor.

The size of a fault has a log-normal prior about `Parameter.typical`: machines with a fault of no
size have no fault, so evidence for "nothing" builds up (as with the non-local priors of Johnson
and Rossell 2010, J. R. Stat. Soc. B 72, 143-170). All other numbers of an effect (periods, drags,
places) are Gaussian about where the fit found them, and cost their Occam factor (MacKay 2003,
Information Theory, Inference and Learning Algorithms, chapter 28).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.priors.options import PENALTIES, SIZE_PRIORS
from deltactl.models.effects.card import Coordinate


@dataclass(frozen=True, slots=True, eq=False)
class SizePrior:
    """The prior of a candidate's moved coordinates.

    sizes: numbers (among the moved ones) of those that are sizes in one unit; typical: their
    median length. one_sided: whether each can only be positive. spread: (k,) standard deviation of
    each coordinate that is no size.
    """

    sizes: list[int]
    typical: float
    one_sided: list[bool]
    spread: FloatArray

    @property
    def others(self) -> list[int]:
        """Numbers of the coordinates that are no sizes."""
        return [i for i in range(len(self.spread)) if i not in self.sizes]

    def log_density(self, length: float) -> float:
        """Log prior density of a vector of sizes of this length (> 0)."""
        count = len(self.sizes)
        width = SIZE_PRIORS.width
        away = math.log(length / self.typical) / width
        radial = -0.5 * away**2 - math.log(width * math.sqrt(2.0 * math.pi)) - math.log(length)
        return radial - math.log(self.sphere) - (count - 1) * math.log(length)

    @property
    def sphere(self) -> float:
        """Surface of the part of the unit sphere that the sizes may point to."""
        count = len(self.sizes)
        whole = 2.0 * math.pi ** (count / 2.0) / math.gamma(count / 2.0)
        return float(whole / 2 ** sum(self.one_sided))


def prior_of(candidate: Candidate, factor: float = 1.0) -> SizePrior:
    """The prior of a candidate's moved coordinates, from its kind's parameters.

    factor: by which sizes are larger and all else is wider than the tables have it.
    """
    kind = candidate.kind
    own = {p.name: p for p in kind.parameters}
    moved = [candidate.coordinates[i] for i in candidate.moved]
    sizes = [i for i, c in enumerate(moved) if own[c.parameter].typical and c.how != "log"]
    typical = own[moved[sizes[0]].parameter].typical if sizes else None
    spread = factor * np.array([own[c.parameter].spread or 1.0 for c in moved])
    one_sided = [_one_sided(candidate, moved[i]) for i in sizes]
    return SizePrior(sizes, factor * (typical or 1.0), one_sided, spread)


def _one_sided(candidate: Candidate, coordinate: Coordinate) -> bool:
    nothing = 0.0 if coordinate.how == "reciprocal" else candidate.kind.nothing
    return coordinate.low >= nothing


def odds_cost(candidate: Candidate) -> float:
    """-2 log of the prior odds that a machine has this effect at this component.

    Three arms that err alike by the same amount are rarer than one cause; what happens once had as
    many moments to happen at.
    """
    together = PENALTIES.group if candidate.members else 0.0
    moment = PENALTIES.event - PENALTIES.coordinate if candidate.kind.event else 0.0
    return -2.0 * math.log(candidate.kind.odds) + candidate.kind.penalty + together + moment


def size_cost(solution: Solution, number: int, factor: float = 1) -> float:
    """-2 log of what the prior of a fitted term's sizes leaves of its likelihood (Laplace).

    factor: by which all priors are wider.
    """
    term = solution.terms[number]
    candidate, prior = term.candidate, prior_of(term.candidate, factor)
    if not len(prior.spread):
        return 0.0
    part = solution.columns_of(number)
    beside = solution.covariance[part, part]
    cost = 0.0
    if prior.sizes:
        away = term.at[candidate.moved] - _nothing(candidate)
        own = beside[np.ix_(prior.sizes, prior.sizes)]
        spread = math.sqrt(max(float(np.trace(own)), 1e-300))
        length = max(float(np.linalg.norm(away[prior.sizes])), spread)
        cost -= 2.0 * prior.log_density(length) + len(prior.sizes) * math.log(2.0 * math.pi)
        cost -= _log_det(own)
    if prior.others:
        precision = np.linalg.pinv(beside, rcond=ESTIMATION.collinear, hermitian=True)
        left = precision[np.ix_(prior.others, prior.others)]
        spread_of = prior.spread[prior.others]
        cost += _log_det(np.eye(len(spread_of)) + left * np.outer(spread_of, spread_of))
    return cost


def _nothing(candidate: Candidate) -> FloatArray:
    """Moved coordinates (k,) at which the effect does nothing."""
    origin = candidate.shapes[0].origin if candidate.shapes else (0.0,) * len(candidate.coordinates)
    return np.array(origin, dtype=np.float64)[candidate.moved]


def _log_det(matrix: FloatArray) -> float:
    values = np.linalg.eigvalsh(matrix)
    return float(np.sum(np.log(np.maximum(values, 1e-300))))


def score_log_odds(
    candidate: Candidate, linear: tuple[int, ...], step: FloatArray, information: FloatArray
) -> float:
    """Log posterior odds of an effect against nothing, from its score at one starting point.

    linear: the coordinates of the score; none: the effect at the starting point.
    step: (k,) with `information` (k, k) of the noise that counts. Sizes that would change the
    readings by less than a few standard deviations do not count: the recording cannot speak of
    them, and "nothing is missing" is said of what it could show.
    """
    along, odds = information @ step, -0.5 * odds_cost(candidate)
    if not linear:
        shows = information[0, 0] >= SIZE_PRIORS.shows**2
        return float(odds + along[0] - 0.5 * information[0, 0]) if shows else -math.inf
    prior = prior_of(candidate)
    ways = _ways(len(step), all(prior.one_sided))
    slopes, bends = ways @ along, np.einsum("di,ij,dj->d", ways, information, ways)
    logs = [_along(prior, float(x), float(y)) for x, y in zip(slopes, bends, strict=True)]
    most = max(logs)
    if most == -math.inf:
        return -math.inf
    return float(odds + most + math.log(sum(math.exp(one - most) for one in logs) / len(logs)))


def _along(prior: SizePrior, slope: float, bend: float) -> float:
    """Log of the likelihood ratio exp(slope r - bend r^2 / 2), averaged over the prior of r."""
    if bend <= 0.0:
        return -math.inf
    width, reach, count = SIZE_PRIORS.width, SIZE_PRIORS.reach_sigma, SIZE_PRIORS.points
    low, high = (prior.typical * math.exp(width * end) for end in (-reach, reach))
    low = max(low, SIZE_PRIORS.shows / math.sqrt(bend))
    if low >= high:
        return -math.inf
    near = slope / bend + np.linspace(-reach, reach, count) / math.sqrt(bend)
    points = np.concatenate([np.geomspace(low, high, count), near[(near > low) & (near < high)]])
    lengths = np.sort(points)
    away = np.log(lengths / prior.typical) / width
    exponents = slope * lengths - 0.5 * bend * lengths**2 - 0.5 * away**2 - np.log(lengths)
    most = float(exponents.max())
    mean = float(trapezoid(np.exp(exponents - most), lengths)) / (width * math.sqrt(2.0 * math.pi))
    return most + math.log(max(mean, 1e-300))


def _ways(count: int, one_sided: bool) -> FloatArray:
    """Directions that sizes may point to, (d, count), evenly drawn."""
    if count == 1:
        return np.array([[1.0]] if one_sided else [[1.0], [-1.0]])
    drawn = np.random.default_rng(0).standard_normal((SIZE_PRIORS.directions, count))
    drawn = np.abs(drawn) if one_sided else drawn
    found: FloatArray = drawn / np.linalg.norm(drawn, axis=1, keepdims=True)
    return found
