"""One step of a fit: the damped normal equations, within the bounds of every coordinate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.candidate import Term
from diagnosis.readings import FloatArray


def _damped(gram: FloatArray, along: FloatArray, damping: float) -> FloatArray:
    """A damped step from the normal equations."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-30))
    matrix = gram / np.outer(scale, scale) + damping * np.eye(len(gram))
    step: FloatArray = np.linalg.lstsq(matrix, along / scale, rcond=1e-10)[0] / scale
    return step


def bounded_step(
    terms: Sequence[Term], jac: FloatArray, residual: FloatArray, damping: float
) -> FloatArray:
    """A damped step; coordinates that would leave their bounds stop there, the rest goes on."""
    room = [
        (term.candidate.coordinates[i].low - term.at[i],
         term.candidate.coordinates[i].high - term.at[i])
        for term in terms
        for i in term.candidate.moved
    ]  # fmt: skip
    low, high = np.array(room).T
    gram, along = jac.T @ jac, jac.T @ residual
    free = np.ones(jac.shape[1], dtype=bool)
    step = np.zeros(jac.shape[1])
    for _ in range(3):
        held = along[free] - gram[np.ix_(free, ~free)] @ step[~free]
        step[free] = _damped(gram[np.ix_(free, free)], held, damping)
        own = step[: len(low)]
        out = free[: len(low)] & ((own < low) | (own > high))
        if not out.any():
            break
        own[out] = np.clip(own[out], low[out], high[out])
        free[: len(low)] &= ~out
    return step[: len(low)]


def moved_by(terms: Sequence[Term], move: FloatArray) -> list[Term]:
    """Terms with their moved coordinates a step further, within their bounds."""
    result, first = [], 0
    for term in terms:
        moved = term.candidate.moved
        at = term.at.copy()
        at[moved] += move[first : first + len(moved)]
        first += len(moved)
        result.append(term.moved_to(at))
    return result
