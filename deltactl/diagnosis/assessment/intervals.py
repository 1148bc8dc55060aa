"""Covariance of fitted sizes, and their intervals where the cost is not parabolic."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from deltactl.diagnosis.answer.records import ParameterResult
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.estimation.estimate import Solution, scaled_covariance
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.priors.tolerances import giving_way, pull

NORMAL_95 = 1.959964
STRAIGHT = 1e-5
"""Along so much of a standard deviation every size changes in proportion."""


def covariance(fitter: Fitter, solution: Solution) -> FloatArray:
    """Covariance of all fitted numbers: the larger of the plain one and the sandwich over blocks of
    time.

    The sandwich (bread, meat of block sums, bread) is scaled on to the plain one's shape by the
    ratio of standard deviations, so that it can only widen an interval. What no robot file can
    promise (`exactness.py`) comes on top.
    """
    rows = fitter.rows
    tangent, residual = solution.tangent, solution.residual
    if not tangent.shape[1]:  # nothing is missing, and readings of angles have no nuisances
        return np.zeros((0, 0))
    bread, scale = scaled_covariance(tangent)
    scaled = tangent / scale
    blocks = fitter.blocks
    product = scaled[:rows] * residual[:rows, None]
    sums = np.stack([np.bincount(blocks, weights=column) for column in product.T], axis=1)
    count = max(len(sums) - 1, 1)
    meat = sums.T @ sums * (len(sums) / count) + scaled[rows:].T @ scaled[rows:]
    sandwich = bread @ meat @ bread
    ratio = np.sqrt(np.maximum(np.diag(sandwich), 1e-300) / np.maximum(np.diag(bread), 1e-300))
    widen = np.clip(ratio, 1.0, 3.0)
    cov: FloatArray = bread * np.outer(widen, widen) / np.outer(scale, scale)
    pulled = pull(fitter, solution, bread / np.outer(scale, scale))
    cov += pulled @ pulled.T + np.diag(giving_way(solution))
    return cov


def parameters(
    term: Term, cov: FloatArray, intervals: dict[str, tuple[float, float]] | None = None
) -> dict[str, ParameterResult]:
    """All fitted parameters of a term; `cov` belongs to its moved coordinates."""
    candidate = term.candidate
    spread = np.zeros(len(candidate.coordinates))
    spread[candidate.moved] = np.sqrt(np.maximum(np.diag(cov), 0.0))
    units = {p.name: p.unit for p in candidate.kind.parameters}
    values = candidate.values(term.at)
    results: dict[str, ParameterResult] = {}
    for name, value in values.items():
        if name in candidate.fixed or name not in units:
            continue
        numbers = [i for i, c in enumerate(candidate.coordinates) if c.parameter == name]
        ci: list[Any] = []
        if intervals and name in intervals:
            ci = list(intervals[name])
        elif np.ndim(value) == 1:
            half = NORMAL_95 * spread[numbers]
            ci = np.stack([value - half, value + half], axis=1).tolist()
        elif name in ("amplitude", "phase"):
            reach = NORMAL_95 * float(np.linalg.norm(_along(term, _independent(cov))[name]))
            ci = [float(value) - reach, float(value) + reach]
        elif numbers:
            ci = sorted(_ends(candidate, term, numbers[0], spread[numbers[0]]))
        if not ci or (np.ndim(value) == 0 and np.isinf(value) and np.isinf(ci[0])):
            continue  # nothing of it, as in the robot file
        results[name] = ParameterResult(value=value.tolist(), ci95=ci, unit=units[name])
    return results


def _ends(candidate: Candidate, term: Term, number: int, spread: float) -> tuple[float, float]:
    coordinate = candidate.coordinates[number]
    at = float(term.at[number])
    low, high = at - NORMAL_95 * spread, at + NORMAL_95 * spread
    # Beyond a bound the fit was not let: the interval has no end there. At nothing it ends.
    if low <= coordinate.low:
        low = 0.0 if coordinate.low == 0.0 and coordinate.how != "log" else -np.inf
    if high >= coordinate.high:
        high = np.inf
    if coordinate.how == "log":
        return float(np.exp(low)), float(np.exp(min(high, 700.0)))
    if coordinate.how == "reciprocal":
        return (1.0 / low if low > 0.0 else np.inf), (1.0 / high if high > 0.0 else np.inf)
    return low, high


def spreads(solution: Solution, cov: FloatArray) -> list[dict[str, list[float]]]:
    """See `Finding.spread`, for each term; cov: of all fitted numbers."""
    ways = _independent(cov)
    every = [_along(t, ways[:, solution.columns_of(k)]) for k, t in enumerate(solution.terms)]
    rows = np.array([row for own in every for row in own.values()]).reshape(-1, len(ways))
    together = iter(np.linalg.qr(rows.T)[1].T)
    trimmed = [{name: np.trim_zeros(next(together), "b") for name in own} for own in every]
    return [{n: [float(f"{x:.3g}") for x in row] for n, row in own.items()} for own in trimmed]


def _independent(cov: FloatArray) -> FloatArray:
    """Rows of how far numbers are off together, a standard deviation each, that are independent."""
    sigma = np.sqrt(np.maximum(np.diag(cov), 1e-300))
    values, vectors = np.linalg.eigh(cov / np.outer(sigma, sigma))
    rows: FloatArray = (sigma[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))).T
    return rows


def _along(term: Term, ways: FloatArray) -> dict[str, FloatArray]:
    """How far each size that is one finite number is off with every row of moved coordinates."""
    steps = np.zeros((len(ways), len(term.at)))
    steps[:, term.candidate.moved] = STRAIGHT * ways
    ends = [[term.candidate.values(term.at + one) for one in (-step, step)] for step in steps]
    return {
        name: np.array([float(high[name] - low[name]) for low, high in ends]) / (2.0 * STRAIGHT)
        for name, value in term.candidate.values(term.at).items()
        if not np.ndim(value) and np.isfinite(value) and name not in term.candidate.fixed
    }


LOSS_95 = 3.841
"""95 % point of chi-square with one degree of freedom."""


def by_profile(
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
    own = np.diag(solution.covariance)[solution.columns_of(number)]
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
