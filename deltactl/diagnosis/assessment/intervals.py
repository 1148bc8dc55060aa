"""Covariance of fitted sizes, and their intervals where the cost is not parabolic."""

from __future__ import annotations

from typing import Any

import numpy as np

from deltactl.diagnosis.answer.records import ParameterResult
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Candidate, Term

NORMAL_95 = 1.959964
STRAIGHT = 1e-5
"""Along so much of a standard deviation every size changes in proportion."""


def parameters(term: Term, cov: FloatArray) -> dict[str, ParameterResult]:
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
        if np.ndim(value) == 1:
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


def spreads(term: Term, cov: FloatArray) -> dict[str, list[float]]:
    """See `Finding.spread`; cov: of the moved coordinates."""
    own = _along(term, _independent(cov))
    rows = np.array(list(own.values())).reshape(-1, len(cov))
    together = iter(np.linalg.qr(rows.T)[1].T)
    trimmed = {name: np.trim_zeros(next(together), "b") for name in own}
    return {name: [float(f"{x:.3g}") for x in row] for name, row in trimmed.items()}


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
