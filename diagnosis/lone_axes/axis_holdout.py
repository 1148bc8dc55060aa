"""Another recording of the same axis: nothing is refitted but what no recording can know."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.estimation.estimate import Solution
from diagnosis.estimation.least_squares import Fitter
from diagnosis.estimation.noise import Whitener
from diagnosis.observations.readings import BoolArray, FloatArray
from diagnosis.plants.candidate import Term
from diagnosis.plants.contract import Model

BLOCKS = 20
EVERY = 4
SIDES = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Where in the play the axis may have stood when the other recording began."""


def other_run(
    model: Model, nuisances: Sequence[Term], solution: Solution, free_zero: bool
) -> tuple[float, float]:
    """RMS before and after. Free there: the side play starts on, and an arbitrary zero."""
    lasting = [term for term in solution.terms if not term.candidate.kind.event]
    observed, valid = model.readings.values[:, 0], model.readings.valid[:, 0]
    before = observed - model.predict(nuisances)[:, 0]
    free = _free_part(model, solution)
    tried = [
        observed - model.predict([*solution.nuisances, *_started(lasting, side)])[:, 0] - free
        for side in (SIDES if any(_number(term) is not None for term in lasting) else (0.0,))
    ]
    after = min(tried, key=lambda x: _rms(x[valid], free_zero))
    return _rms(before[valid], free_zero), _rms(after[valid], free_zero)


def held_blocks(
    fitter: Fitter, solution: Solution, believed: FloatArray, valid: BoolArray
) -> tuple[float, float]:
    """RMS before and after on whole blocks of time that a refit has not seen."""
    t_s = fitter.model.readings.t_s
    block = np.minimum(((t_s - t_s[0]) / np.ptp(t_s) * BLOCKS).astype(int), BLOCKS - 1)
    held = block % EVERY == EVERY // 2
    white = fitter.whiten
    weight = np.where(held[white.rows], 0.0, white.weight)
    partial = Fitter(fitter.model, Whitener(white.channels, weight), fitter.nuisances)
    refit = partial.solve(solution.terms, solution.frees, solution.nuisances, steps=3)
    seen = held & valid[:, 0]
    observed = fitter.observed[seen, 0]
    return (
        _rms(observed - believed[seen, 0], False),
        _rms(observed - refit.predicted[seen, 0], False),
    )


def _rms(values: FloatArray, free_zero: bool) -> float:
    if not values.size:
        return 0.0
    off = float(np.mean(values)) if free_zero else 0.0
    return float(np.sqrt(np.mean((values - off) ** 2)))


def _number(term: Term) -> int | None:
    names = [c.parameter for c in term.candidate.coordinates]
    return names.index("start") if "start" in names else None


def _started(terms: Sequence[Term], side: float) -> list[Term]:
    moved = []
    for term in terms:
        number = _number(term)
        if number is not None:
            at = term.at.copy()
            at[number] = side
            term = Term(term.candidate, at)
        moved.append(term)
    return moved


def _free_part(model: Model, solution: Solution) -> FloatArray:
    total, first = np.zeros(len(model.readings.t_s)), 0
    ports, drivers = model.ports(), model.drivers()
    for free in solution.frees:
        basis = free.basis_for(drivers[free.driver])
        part = solution.coefficients[first : first + basis.shape[1]]
        total += ports[free.port][:, 0] * (basis @ part)
        first += basis.shape[1]
    return total
