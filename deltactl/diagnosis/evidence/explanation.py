"""One set of regressors at its best sizes, and what is read off it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from deltactl.diagnosis.evidence.scalar_products import left_of
from deltactl.diagnosis.observations.readings import FloatArray, IntArray

Point = dict[str, float]
"""Nonlinear sizes by their full names."""


@dataclass(frozen=True, eq=False)
class Explanation:
    """A set of regressors at its best sizes.

    linear: key -> coefficients (k,). parts: shapes (n, k) with their coefficients, whose sum is
    what is predicted beyond `base`. observed: (n,) in the unit of the readings.
    chi2: of the whitened rows alone. penalised: with the priors of the sizes.
    shapes: whitened shapes times prior spread, which sets share; names: of their columns,
    `key.size`; taken: those that its regressors take over.
    log_evidence: with the prior odds of the set.
    """

    keys: frozenset[str]
    found: frozenset[str]
    """Less those whose size any machine has as built."""
    sizes: Point
    linear: dict[str, FloatArray]
    base: FloatArray
    parts: tuple[tuple[FloatArray, FloatArray], ...]
    observed: FloatArray
    chi2: float
    penalised: float
    log_evidence: float
    charged: float
    """Chi-square that is no evidence for the set (`RegressionPlant.charged`)."""
    shapes: tuple[FloatArray, ...]
    taken: IntArray
    names: tuple[str, ...]
    spreads: FloatArray
    target: FloatArray
    """Whitened model error (m,) by the base."""
    theta: FloatArray
    """Linear sizes (p,), each in its prior spread."""
    products: Callable[[], FloatArray]
    """Scalar products of all shapes."""

    @cached_property
    def gram(self) -> FloatArray:
        """Scalar products (p, p) of all shapes."""
        return self.products()

    @property
    def beyond_noise(self) -> float:
        """Chi-square that is left for each reading, above that of noise."""
        return self.chi2 / max(len(self.target), 1) - 1.0

    @cached_property
    def white(self) -> FloatArray:
        """Whitened residual (m,), computed once it is asked for: of most sets it never is."""
        return left_of(self.target, self.shapes, self.theta)

    @cached_property
    def predicted(self) -> FloatArray:
        """(n,), computed once it is asked for: of most sets it never is."""
        predicted = self.base
        for values, size in self.parts:
            predicted = predicted + values @ size
        return predicted

    @cached_property
    def residual(self) -> FloatArray:
        """(n,) in the unit of the readings."""
        return self.observed - self.predicted

    @property
    def tangent(self) -> FloatArray:
        """All shapes side by side, (m, p)."""
        return side_by_side(len(self.target), self.shapes, self.taken)


def side_by_side(rows: int, shapes: Sequence[FloatArray], taken: IntArray) -> FloatArray:
    """Columns (rows, p) of several shapes; none where they are taken."""
    columns: FloatArray = np.concatenate([np.zeros((rows, 0)), *shapes], axis=1)
    columns[:, taken] = 0.0
    return columns
