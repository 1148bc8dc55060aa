"""What every machine may be off by as it is built, and what its robot file may be off by."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.side_by_side import side_by_side
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.contract import Model
from deltactl.diagnosis.plants.nuisance import Nuisance
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


def tolerance_columns(fitter: Fitter, around: Sequence[Term]) -> FloatArray:
    """Whitened changes by an error of its spread in every size of the machine, (m, k).

    around: terms at work. No columns for errors that are fitted with wider spreads already.
    """
    model = fitter.model
    fitted = {n.term.candidate.key for n in fitter.nuisances}
    as_it_is = model.predict(around)

    def column(nuisance: Nuisance, i: int, spread: float) -> FloatArray:
        at, step = nuisance.term.at.copy(), nuisance.term.candidate.coordinates[i].step
        at[i] += step
        moved = model.predict([*around, nuisance.term.moved_to(at)]) - as_it_is
        return PENALTIES.most_careful * spread / step * fitter.vector(moved)

    tasks = [
        partial(column, nuisance, i, spread)
        for nuisance in model.tolerances
        if nuisance.term.candidate.key not in fitted
        for i, spread in zip(nuisance.term.candidate.moved, nuisance.spread, strict=True)
    ]
    nothing = np.zeros(len(fitter.vector(as_it_is)))
    return np.stack([nothing, *side_by_side(tasks)], axis=1)


def pull(fitter: Fitter, solution: Solution, bread: FloatArray) -> FloatArray:
    """How far build tolerances pull the fitted numbers, (p, k): a column an error.

    bread: inverse of the tangent's Gram matrix, (p, p).
    """
    small = tolerance_columns(fitter, [*solution.nuisances, *solution.terms])
    return bread @ (solution.tangent.T @ small)


def giving_way(solution: Solution) -> FloatArray:
    """Variance that each fitted number has from stops that give way, (p,)."""
    variance = np.zeros(solution.tangent.shape[1])
    for number, term in enumerate(solution.terms):
        for place, i in enumerate(term.candidate.moved):
            name = term.candidate.coordinates[i].parameter
            spread = term.candidate.kind.discrepancy.gives_way.get(name, 0.0)
            variance[solution.columns_of(number).start + place] = spread**2
    return variance
