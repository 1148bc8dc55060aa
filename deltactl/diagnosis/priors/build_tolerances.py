"""Errors no larger than every machine built with care may have."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.contract import Model
from deltactl.diagnosis.plants.traits import traits_of
from deltactl.diagnosis.priors.options import PENALTIES


def effects_of_building(model: Model) -> set[str]:
    """The effects that every machine has a little of."""
    return {nuisance.term.candidate.effect for nuisance in model.tolerances}


def within_tolerance(model: Model, term: Term) -> bool:
    """Whether a wrong size of the machine is within what building leaves."""
    candidate = term.candidate
    spreads = {n.term.candidate.key: n.spread for n in model.tolerances}
    if candidate.effect not in traits_of(model).build_effects or candidate.key not in spreads:
        return False
    size = term.at[candidate.moved] - np.array(candidate.shapes[0].origin)[candidate.moved]
    return bool(np.all(np.abs(size) < PENALTIES.within * np.array(spreads[candidate.key])))
