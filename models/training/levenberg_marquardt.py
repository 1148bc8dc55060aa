"""Levenberg-Marquardt for least squares with an analytic Jacobian.

Marquardt 1963, J. SIAM 11, 431, with the damping rule of Hagan and Menhaj 1994 (IEEE
Trans. Neural Networks 5, 989): smaller after a step that helps, larger until one does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from deltactl.models.robot import FloatArray

Residuals = Callable[[FloatArray], FloatArray]
"""Parameters (p,) to residuals (n,)."""
Jacobian = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Parameters (p,) to residuals (n,) and their derivatives (n, p)."""

SHRINK, GROW = 1.0 / 3.0, 4.0
DAMPING_RANGE = (1e-14, 1e12)


class Normal(NamedTuple):
    """Sum of squared residuals, J'J (p, p) and J'e (p,) at some parameters."""

    cost: float
    matrix: FloatArray
    gradient: FloatArray


@dataclass(frozen=True)
class Step:
    """State of the search after an iteration that helped."""

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

    def cost(parameters: FloatArray) -> float:
        return float(np.sum(residuals(parameters) ** 2))

    def normal(parameters: FloatArray) -> Normal:
        error, slope = jacobian(parameters)
        return Normal(float(error @ error), slope.T @ slope, slope.T @ error)

    return steps_by_normal(cost, normal, start, damping)


def steps_by_normal(
    cost: Callable[[FloatArray], float],
    normal: Callable[[FloatArray], Normal],
    start: FloatArray,
    damping: float = 1e-2,
) -> Iterator[Step]:
    """`steps` for problems whose normal equations are cheaper than their Jacobian."""
    parameters, iteration = start, 0
    here = normal(parameters)
    least = here.cost
    while True:
        while True:
            trial = _solve(here.matrix, here.gradient, damping, parameters)
            trial_cost = np.inf if trial is None else cost(trial)
            if trial is not None and trial_cost < least:
                break
            damping *= GROW
            if damping > DAMPING_RANGE[1]:
                return
        damping = max(damping * SHRINK, DAMPING_RANGE[0])
        parameters, least, iteration = trial, trial_cost, iteration + 1
        yield Step(iteration, parameters, least, damping)
        here = normal(parameters)


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
