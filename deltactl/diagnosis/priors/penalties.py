"""What an effect must gain before it is named, and what its operator may leave behind."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.priors.options import PENALTIES


def penalty(candidate: Candidate) -> float:
    """What a candidate must earn."""
    if candidate.kind.event:
        return PENALTIES.event
    together = PENALTIES.group if candidate.members else 0.0
    return PENALTIES.coordinate * len(candidate.moved) + candidate.kind.penalty + together


def penalty_of(term: Term) -> float:
    """What a term must earn where the fit has brought it."""
    return penalty(term.candidate) + (PENALTIES.in_name_only if _in_name_only(term) else 0.0)


def _in_name_only(term: Term) -> bool:
    """Outside the range in which it is itself; a wave of its whole travel, which is one bend."""
    for coordinate, at in zip(term.candidate.coordinates, term.at, strict=True):
        name = coordinate.parameter
        if name == "period" and at > coordinate.high + np.log(PENALTIES.whole_travel):
            return True
        low, high = term.candidate.kind.itself.get(name, (-np.inf, np.inf))
        if not low <= at <= high:
            return True
    return False
