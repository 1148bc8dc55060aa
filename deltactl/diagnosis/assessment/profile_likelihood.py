"""Intervals of sizes that a fit cannot be straight in: by what the fit loses, not by its slope.

How fast a machine warms and how far are told apart by a bend in a curve. Where the bend is faint
the cost is no parabola, and a slope at its lowest point says nothing about its rim. There the
interval is what refits within the loss that 95 % allows (profile likelihood; Venzon and
Moolgavkar 1988), the loss scaled as the sandwich scales the plain variance.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Term

LOSS_95 = 3.841
"""95 % point of chi-square with one degree of freedom."""


def intervals(
    fitter: Fitter, solution: Solution, number: int, cov: FloatArray
) -> dict[str, tuple[float, float]] | None:
    """Interval of each parameter of term `number`; None where the straight ones will do.

    cov: covariance of the term's moved coordinates, widened as the sandwich asks.
    """
    term = solution.terms[number]
    moved = term.candidate.moved
    hows = [term.candidate.coordinates[i].how for i in moved]
    spread = np.sqrt(np.maximum(np.diag(cov), 0.0))
    bent = [how == "log" and s > ASSESSMENT.bent for how, s in zip(hows, spread, strict=True)]
    if len(moved) != 2 or sorted(hows) != ["log", "plain"] or not any(bent):
        return None
    plain = np.linalg.pinv(solution.tangent.T @ solution.tangent, hermitian=True)
    own = np.diag(plain)[solution.columns_of(number)]
    widen = np.clip(spread**2 / np.maximum(own, 1e-300), 1.0, 9.0)
    ends = fitter.side_by_side(
        [
            partial(_end, fitter, solution, number, i, side * one, LOSS_95 * wide)
            for i, one, wide in zip(moved, spread.tolist(), widen.tolist(), strict=True)
            for side in (-1.0, 1.0)
        ]
    )
    found = {}
    for place, i in enumerate(moved):
        both = ends[2 * place : 2 * place + 2]
        low, high = (float(np.exp(x)) if hows[place] == "log" else x for x in both)
        found[term.candidate.coordinates[i].parameter] = (low, high)
    return found


def _end(
    fitter: Fitter, solution: Solution, number: int, i: int, spread: float, loss: float
) -> float:
    """Where coordinate `i` may be held on one side before the refit loses too much."""
    term = solution.terms[number]
    coordinate, start = term.candidate.coordinates[i], float(term.at[i])
    reach, near = float(np.sqrt(loss)) * spread, solution
    end = float(start + reach)
    for _ in range(ASSESSMENT.profile_tries):
        end = float(np.clip(start + reach, coordinate.low, coordinate.high))
        held = _held(near.terms[number], i, end)
        terms = (*near.terms[:number], held, *near.terms[number + 1 :])
        near = fitter.solve(
            terms, near.frees, near.nuisances, ASSESSMENT.profile_steps, solution.named_tangent
        )
        lost = max(near.cost - solution.cost, 1e-3 * loss)
        at_bound = end in (coordinate.low, coordinate.high)
        if abs(lost / loss - 1.0) < ASSESSMENT.profile_close or (at_bound and lost < loss):
            break
        further = (end - start) * float(np.clip(np.sqrt(loss / lost), 0.4, 2.0))
        furthest = ASSESSMENT.profile_furthest * abs(spread)
        reach = float(np.clip(further, -furthest, furthest))
        if reach == end - start:
            break
    return end


def _held(term: Term, i: int, value: float) -> Term:
    """The term with one coordinate that cannot move from a value."""
    coordinates = list(term.candidate.coordinates)
    coordinates[i] = replace(coordinates[i], low=value, high=value)
    at = term.at.copy()
    at[i] = value
    return Term(replace(term.candidate, coordinates=tuple(coordinates)), at)
