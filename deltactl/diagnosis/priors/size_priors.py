"""What an effect costs in evidence: prior odds, the prior of its size, and its Occam factor.

The size of a fault has a log-normal prior about `Parameter.typical`: machines with a fault of no
size have no fault, so evidence for "nothing" builds up (as with the non-local priors of Johnson
and Rossell 2010, J. R. Stat. Soc. B 72, 143-170). A drag is log-normal about its default: without
end it would be friction. All other numbers of an effect (periods, places) are Gaussian about where
the fit found them, and cost their Occam factor (MacKay 2003, Information Theory, Inference and
Learning Algorithms, chapter 28).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate
from deltactl.diagnosis.priors.options import PENALTIES
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


def prior_of(candidate: Candidate) -> SizePrior:
    """The prior of a candidate's moved coordinates, from its kind's parameters."""
    kind = candidate.kind
    own = {p.name: p for p in kind.parameters}
    moved = [candidate.coordinates[i] for i in candidate.moved]
    sizes = [i for i, c in enumerate(moved) if own[c.parameter].typical and c.how != "log"]
    typical = own[moved[sizes[0]].parameter].typical if sizes else None
    spread = np.array([own[c.parameter].spread or 1.0 for c in moved])
    one_sided = [_one_sided(candidate, moved[i]) for i in sizes]
    return SizePrior(sizes, typical or 1.0, one_sided, spread)


def _one_sided(candidate: Candidate, coordinate: Coordinate) -> bool:
    nothing = 0.0 if coordinate.how == "reciprocal" else candidate.kind.nothing
    return coordinate.low >= nothing


def odds_cost(candidate: Candidate) -> float:
    """-2 log of the prior odds that a machine has this effect at this component.

    Three arms that err alike by the same amount are rarer than one cause; what happens once had as
    many moments to happen at.
    """
    together = PENALTIES.group if candidate.members else 0.0
    moment = PENALTIES.event if candidate.kind.event else 0.0
    return -2.0 * math.log(candidate.kind.odds) + candidate.kind.penalty + together + moment
