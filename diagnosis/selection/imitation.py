"""How probable it is that a name beside unknown physics is more than an imitation of a part of it.

Two pictures are weighed. What is unknown stays where its spline term stands: then a name elsewhere
is a cause of its own. Or it acts on the whole machine, which a spline at one place can only follow
in part: then names imitate the rest, and the more of them stand there, the likelier this is. A name
that acts where the unknown does is told from a part of it by nothing but the name's form.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.least_squares import Fitter
from diagnosis.observations.readings import FloatArray
from diagnosis.selection.options import CREDIBLE


def causes_of_their_own(fitter: Fitter, solution: Solution) -> list[float]:
    """For each term, the probability that it is no imitation; 1 where nothing is unknown."""
    if not solution.frees:
        return [1.0] * len(solution.terms)
    return chances([_share_there(fitter, solution, k) for k in range(len(solution.terms))])


def chances(shares: Sequence[float]) -> list[float]:
    """The same, from the share of each term's change that acts where an unknown does."""
    there = [share > CREDIBLE.same_place for share in shares]
    elsewhere = min(there.count(False), CREDIBLE.names_counted)
    odds = CREDIBLE.everywhere * CREDIBLE.names_imitate**elsewhere
    return [CREDIBLE.beside_in_place if one else 1.0 / (1.0 + odds) for one in there]


def _share_there(fitter: Fitter, solution: Solution, number: int) -> float:
    """Of the square of a term's change, in standard deviations of the noise, what a spline term
    could take up if it were free at every sample.
    """
    rest = (*solution.terms[:number], *solution.terms[number + 1 :])
    model = fitter.model
    change = model.predict([*solution.nuisances, *solution.terms])
    change = change - model.predict([*solution.nuisances, *rest])
    spread = np.array([noise.spread for noise in fitter.whiten.channels])
    scaled = change / spread
    whole = float(np.sum(scaled**2))
    if whole == 0.0:
        return 1.0
    places = {free.location for free in solution.frees}
    taken = [_along(scaled, model.inputs()[place] / spread) for place in sorted(places)]
    return max(taken) / whole


def _along(change: FloatArray, direction: FloatArray) -> float:
    """Sum of squares of what of each row of a change (n, channels) lies along its direction."""
    length = np.maximum(np.sum(direction**2, axis=1), 1e-30)
    return float(np.sum(np.sum(change * direction, axis=1) ** 2 / length))
