"""Levenberg-Marquardt for least squares with an analytic Jacobian.

Marquardt 1963, J. SIAM 11, 431, with the damping rule of Hagan and Menhaj 1994 (IEEE
Trans. Neural Networks 5, 989): smaller after a step that helps, larger until one does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from models.robot import FloatArray

Residuals = Callable[[FloatArray], FloatArray]
"""Parameters (p,) to residuals (n,)."""
Jacobian = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Parameters (p,) to residuals (n,) and their derivatives (n, p)."""

SHRINK, GROW = 1.0 / 3.0, 4.0
DAMPING_RANGE = (1e-14, 1e12)


@dataclass(frozen=True)
class Step:
    """Where the search stands after an iteration that helped."""

    iteration: int
    parameters: FloatArray
    cost: float
    """Sum of squared residuals."""
    damping: float


def steps(
    residuals: Residuals,
    jacobian: Jacobian,
    start: FloatArray,
    damping: float = 1e-2,
) -> Iterator[Step]:
    """Improve `start` for as long as the caller asks; ends when no step helps any more."""
    parameters, iteration = start, 0
    error, slope = jacobian(parameters)
    cost = float(error @ error)
    while True:
        normal, gradient = slope.T @ slope, slope.T @ error
        while True:
            trial = _solve(normal, gradient, damping, parameters)
            trial_cost = np.inf if trial is None else float(np.sum(residuals(trial) ** 2))
            if trial is not None and trial_cost < cost:
                break
            damping *= GROW
            if damping > DAMPING_RANGE[1]:
                return
        damping = max(damping * SHRINK, DAMPING_RANGE[0])
        parameters, cost, iteration = trial, trial_cost, iteration + 1
        yield Step(iteration, parameters, cost, damping)
        error, slope = jacobian(parameters)


def _solve(
    normal: FloatArray, gradient: FloatArray, damping: float, parameters: FloatArray
) -> FloatArray | None:
    """The damped step from `parameters`, or None when the equations cannot be solved."""
    damped = normal.copy()
    damped[np.diag_indices_from(damped)] += damping
    try:
        change: FloatArray = cho_solve(cho_factor(damped, overwrite_a=True), gradient)
    except LinAlgError:
        return None
    return parameters - change
