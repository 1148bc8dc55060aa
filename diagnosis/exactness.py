"""What a robot file cannot promise: how exact the machine behind it is at best.

A long recording tells a length to a hundredth of a millimetre, but no machine is like its file to
that: joints sag under their own weight, a stop gives way under what presses on it. An interval
says where the truth is, so it has room for such small errors everywhere, whether seen or not.
"""

from __future__ import annotations

import numpy as np

from diagnosis.fit import Fitter, Solution
from diagnosis.readings import FloatArray

EXACT = 1.0 / 60.0
"""Share of the usual tolerances that the most careful building leaves: 0.025 mm at a sensor,
0.01 mm in an arm, 0.03 mrad at a home."""
COLLINEAR = 1e-6
GIVES_WAY_M = 2.5e-4
"""How far stop and pad give way under a pressing platform (standard deviation)."""
STOP = ("contact", "height")


def small_errors(fitter: Fitter) -> FloatArray:
    """Whitened changes by an error of its spread in every size of the nominal machine, (m, k)."""
    model = fitter.model
    always = [nuisance.term for nuisance in fitter.nuisances]
    nominal = model.predict(always)
    columns = [np.zeros(len(fitter.vector(nominal)))]
    for nuisance in model.tolerances:
        candidate = nuisance.term.candidate
        for i, spread in zip(candidate.moved, nuisance.spread, strict=True):
            at = nuisance.term.at.copy()
            at[i] += candidate.coordinates[i].step
            changed = model.predict([*always, nuisance.term.moved_to(at)]) - nominal
            columns.append(EXACT * spread / candidate.coordinates[i].step * fitter.vector(changed))
    return np.stack(columns, axis=1)


def doubt(gram: FloatArray, with_small: FloatArray) -> float:
    """How many times more a test's score may be by small errors than by noise alone.

    gram: of the test's columns, (k, k). with_small: their products with `small_errors`, (k, n).
    """
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-30))
    values, vectors = np.linalg.eigh(gram / np.outer(scale, scale))
    usable = values > COLLINEAR
    if not usable.any():
        return 1.0
    along = vectors[:, usable].T @ (with_small / scale[:, None])
    return 1.0 + float(np.sum(along**2 / values[usable, None])) / int(usable.sum())


def pull(fitter: Fitter, solution: Solution, bread: FloatArray) -> FloatArray:
    """How far small errors everywhere pull the fitted numbers, (p, k): a column an error.

    bread: inverse of the tangent's Gram matrix, (p, p). No columns for errors that are fitted
    with wider spreads already.
    """
    model = fitter.model
    fitted = {n.term.candidate.key for n in fitter.nuisances}
    terms = [*solution.nuisances, *solution.terms]
    as_fitted = model.predict(terms)
    columns = [np.zeros(len(solution.residual))]
    for nuisance in model.tolerances:
        candidate, start = nuisance.term.candidate, nuisance.term.at
        if candidate.key in fitted:
            continue
        for i, spread in zip(candidate.moved, nuisance.spread, strict=True):
            at = start.copy()
            at[i] += candidate.coordinates[i].step
            moved = model.predict([*terms, nuisance.term.moved_to(at)]) - as_fitted
            share = EXACT * spread / candidate.coordinates[i].step
            columns.append(share * fitter.vector(moved))
    along: FloatArray = bread @ (solution.tangent.T @ np.stack(columns, axis=1))
    return along


def giving_way(solution: Solution) -> FloatArray:
    """Variance that each fitted number has from stops that give way, (p,)."""
    variance = np.zeros(solution.tangent.shape[1])
    for number, term in enumerate(solution.terms):
        for place, i in enumerate(term.candidate.moved):
            if (term.candidate.effect, term.candidate.coordinates[i].parameter) == STOP:
                variance[solution.columns_of(number).start + place] = GIVES_WAY_M**2
    return variance
