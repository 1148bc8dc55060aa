"""One step of a fit: the damped normal equations, within the bounds of every coordinate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from deltactl.diagnosis.observations.readings import BoolArray, FloatArray
from deltactl.diagnosis.plants.candidate import Term


class Slopes:
    """Steps along a tangent (m, p), less what an orthonormal basis (m, q) takes of it."""

    def __init__(self, tangent: FloatArray, basis: FloatArray):
        self.tangent = tangent
        gram = tangent.T @ tangent
        self._taken = basis.T @ tangent
        self._scale = np.sqrt(np.maximum(np.diag(gram), 1e-30))
        self._gram = gram - self._taken.T @ self._taken

    def bounded_step(
        self, terms: Sequence[Term], residual: FloatArray, taken: FloatArray, damping: float
    ) -> tuple[FloatArray, float]:
        """A damped step; coordinates that would leave their bounds stop there, the rest goes on.

        taken: what the basis has of the residual, (q,). Also returns the chi-square that the step
        would gain if the tangent held all the way.
        """
        moved = [(t.candidate.coordinates[i], t.at[i]) for t in terms for i in t.candidate.moved]
        low, high = np.array([(one.low - at, one.high - at) for one, at in moved]).T
        along = self.tangent.T @ residual - self._taken.T @ taken
        free = np.ones(len(along), dtype=bool)
        step = np.zeros(len(along))
        for _ in range(3):
            held = along[free] - self._gram[np.ix_(free, ~free)] @ step[~free]
            step[free] = self._damped(free, held, damping)
            out = free & ((step < low) | (step > high))
            if not out.any():
                break
            step[out] = np.clip(step[out], low[out], high[out])
            free &= ~out
        return step, float(2.0 * along @ step - step @ self._gram @ step)

    def _damped(self, free: BoolArray, along: FloatArray, damping: float) -> FloatArray:
        """A damped step of the free coordinates from the normal equations."""
        scale = self._scale[free]
        matrix = self._gram[np.ix_(free, free)] / np.outer(scale, scale)
        matrix += damping * np.eye(len(scale))
        step: FloatArray = np.linalg.lstsq(matrix, along / scale, rcond=1e-10)[0] / scale
        return step


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
