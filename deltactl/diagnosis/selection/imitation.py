"""How probable it is that a name beside unknown physics is more than an imitation of a part of it.

Two hypotheses are weighed. The unknown acts only where its spline term is: then a name elsewhere
is a cause of its own. Or it acts on the whole machine, which a spline at one place can only follow
in part: then names imitate the rest, and the more of them there are, the likelier this is. A name
that acts where the unknown does differs from a part of it in nothing but the name's form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.selection.options import CREDIBLE


@dataclass(frozen=True, slots=True)
class Beside:
    """How a term compares with what is unknown."""

    own: float = 1.0
    """Probability that it is a cause of its own."""
    place: str = ""
    """Place of the unknown that it imitates otherwise; empty where nothing is unknown."""


def beside_unknown(fitter: Fitter, solution: Solution) -> list[Beside]:
    """For each term, whether it may be an imitation, and of what."""
    if not solution.frees:
        return [Beside()] * len(solution.terms)
    whole = fitter.model.predict([*solution.nuisances, *solution.terms])
    inputs = fitter.model.inputs()
    places = {free.location: fitter.in_noise(inputs[free.location]) for free in solution.frees}
    nearest = [
        _nearest(fitter.in_noise(fitter.change_by(solution, number, whole)), places)
        for number in range(len(solution.terms))
    ]
    own = chances([share for share, _ in nearest])
    return [Beside(one, place) for one, (_, place) in zip(own, nearest, strict=True)]


def chances(shares: Sequence[float]) -> list[float]:
    """The same, from the share of each term's change that acts where an unknown does."""
    there = [share > CREDIBLE.same_place for share in shares]
    elsewhere = min(there.count(False), CREDIBLE.names_counted)
    odds = CREDIBLE.everywhere * CREDIBLE.names_imitate**elsewhere
    return [CREDIBLE.beside_in_place if one else 1.0 / (1.0 + odds) for one in there]


def _nearest(change: FloatArray, places: Mapping[str, FloatArray]) -> tuple[float, str]:
    """The largest share of the square of a term's change that one of the spline terms could take
    up if it were free at every sample; and the place of that term.

    Both in standard deviations of the noise, (n, channels); places: what a unit there changes.
    """
    size = float(np.sum(change**2))
    if size == 0.0:
        return 1.0, min(places)
    return max((_along(change, unit) / size, place) for place, unit in places.items())


def _along(change: FloatArray, direction: FloatArray) -> float:
    """Sum of squares of what of each row of a change (n, channels) lies along its direction."""
    length = np.maximum(np.sum(direction**2, axis=1), 1e-30)
    return float(np.sum(np.sum(change * direction, axis=1) ** 2 / length))
