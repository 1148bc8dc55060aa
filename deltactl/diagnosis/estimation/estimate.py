"""What a fit found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.estimation.splines import SplineTerm
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.candidate import Term


@dataclass(frozen=True, eq=False)
class Solution:
    """Fitted terms. cost is a chi-square; residual (m,) is whitened."""

    terms: tuple[Term, ...]
    nuisances: tuple[Term, ...]
    frees: tuple[SplineTerm, ...]
    coefficients: FloatArray
    cost: float
    residual: FloatArray
    predicted: FloatArray
    """Channels with everything fitted, (n, channels)."""
    slopes: Callable[[], FloatArray]
    """Works the tangent out."""

    @cached_property
    def tangent(self) -> FloatArray:
        """Whitened derivatives (m, p) by nuisances, moved coordinates, spline terms."""
        return self.slopes()

    def __getstate__(self) -> dict[str, Any]:
        """What is sent between processes: not what follows from the tangent."""
        follows = ("basis", "covariance")
        return {name: value for name, value in self.__dict__.items() if name not in follows}

    @cached_property
    def basis(self) -> FloatArray:
        """Orthonormal basis of the tangent, (m, rank)."""
        return orthonormal(self.tangent)

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of all fitted numbers, (p, p), by the noise alone."""
        scaled, scale = scaled_covariance(self.tangent)
        return scaled / np.outer(scale, scale)

    @property
    def named_tangent(self) -> FloatArray:
        """The tangent without the columns of spline terms."""
        return self.tangent[:, : self.tangent.shape[1] - len(self.coefficients)]

    @property
    def free_tangent(self) -> FloatArray:
        """The tangent without coordinates at an end of their range, which cannot give way."""
        stuck = [
            term.at[i] in (term.candidate.coordinates[i].low, term.candidate.coordinates[i].high)
            for term in (*self.nuisances, *self.terms)
            for i in term.candidate.moved
        ]
        if not any(stuck):
            return self.tangent
        keep = np.ones(self.tangent.shape[1], dtype=bool)
        keep[: len(stuck)] = ~np.array(stuck, dtype=bool)
        return self.tangent[:, keep]

    @property
    def free_basis(self) -> FloatArray:
        """Orthonormal basis of that, (m, rank)."""
        free = self.free_tangent
        return self.basis if free is self.tangent else orthonormal(free)

    def columns_of(self, number: int) -> slice:
        """Columns of the tangent that belong to term `number`."""
        first = sum(len(t.candidate.moved) for t in self.nuisances)
        first += sum(len(t.candidate.moved) for t in self.terms[:number])
        return slice(first, first + len(self.terms[number].candidate.moved))


def without(terms: Sequence[Term], number: int) -> tuple[Term, ...]:
    """Terms less one."""
    return (*terms[:number], *terms[number + 1 :])


def scaled_covariance(tangent: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Covariance (p, p) of numbers in units in which each column has length one; and these (p,).

    tangent: whitened derivatives (m, p). Directions that move nothing get no variance.
    """
    scale = np.maximum(np.linalg.norm(tangent, axis=0), 1e-30)
    scaled = tangent / scale
    return np.linalg.pinv(scaled.T @ scaled, rcond=ESTIMATION.collinear, hermitian=True), scale


def orthonormal(tangent: FloatArray) -> FloatArray:
    """Orthonormal basis of the columns (those that count).

    From their Gram matrix, twice: the second time mends what rounding left of the first.
    """
    basis: FloatArray = tangent / np.maximum(np.linalg.norm(tangent, axis=0), 1e-30)
    for least in (ESTIMATION.standing_out**2, 0.0):
        if not basis.shape[1]:
            break
        values, vectors = np.linalg.eigh(basis.T @ basis)
        kept = values > least * values[-1]
        basis = basis @ (vectors[:, kept] / np.sqrt(values[kept]))
    return basis


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """Terms, what they predict, and what spline terms leave of the rest."""

    nuisances: tuple[Term, ...]
    terms: tuple[Term, ...]
    predicted: FloatArray
    """Channels (n, channels)."""
    residual: FloatArray
    """Whitened, (m,)."""
    taken: FloatArray
    """What an orthonormal basis of the spline terms has of the residual, (q,)."""
    cost: float
    """Chi-square of the rest."""

    @property
    def everything(self) -> list[Term]:
        """Nuisances, then terms."""
        return [*self.nuisances, *self.terms]
