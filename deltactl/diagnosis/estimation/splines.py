"""Spline terms: a spline of one covariate at one place, an alternative to every named effect."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array, diags_array

from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.contract import Model
from deltactl.diagnosis.plants.options import SPLINE_TERMS
from deltactl.diagnosis.plants.traits import traits_of


@dataclass(frozen=True, slots=True, eq=False)
class SplineTerm:
    """A location, what the shape depends on, and its columns (n, k), few of which a sample meets.

    covariate: a name, or two with a comma for a quantity made of both. kind: a spline of it, one
    that changes sign with the way the covariate came (play that is wider at some places
    than at others), or sine and cosine of time `rate_hz` times a second.
    """

    location: str
    covariate: str
    basis: csr_array
    knots: FloatArray
    kind: Literal["spline", "way", "sinusoid"] = "spline"
    rate_hz: float = 0.0

    @property
    def depends_on(self) -> list[str]:
        """The names in the covariate."""
        return self.covariate.split(", ")

    @property
    def size(self) -> int:
        """How many coefficients it has."""
        return int(self.basis.shape[1])

    def columns(self, change: FloatArray) -> FloatArray:
        """Change of the channels per coefficient, (n, channels, k)."""
        basis: FloatArray = self.basis.toarray()
        return change[:, :, None] * basis[:, None, :]

    def basis_for(self, covariate: FloatArray) -> csr_array:
        """The same shape over another run of its covariate, (n, k)."""
        if self.kind == "sinusoid":
            return waves(covariate, self.rate_hz)
        basis = spline_basis(covariate, self.knots)
        return basis if self.kind == "spline" else two_way(covariate, basis)


Score = tuple[SplineTerm, float, float]
"""A shape, the chi-square it would gain beside a solution, and log p of that."""


def knots_for(covariate: FloatArray, pieces: int = ESTIMATION.pieces) -> FloatArray:
    """Knots half-way between quantiles and equal steps, so that none spans an empty range."""
    share = np.linspace(0.0, 1.0, pieces + 1)
    inner = 0.5 * (np.quantile(covariate, share) + covariate.min() + np.ptp(covariate) * share)
    inner = np.maximum.accumulate(inner + 1e-12 * np.arange(len(inner)))
    degree = SPLINE_TERMS.spline_degree
    return np.concatenate([[inner[0]] * degree, inner, [inner[-1]] * degree])


def spline_basis(covariate: FloatArray, knots: FloatArray) -> csr_array:
    """Cubic B-splines of a covariate, constant beyond the outer knots; (n, pieces + 3)."""
    inside = np.clip(covariate, knots[0], knots[-1] - 1e-12)
    return csr_array(BSpline.design_matrix(inside, knots, SPLINE_TERMS.spline_degree))


def waves(t_s: FloatArray, rate_hz: float) -> csr_array:
    """Sine and cosine of time, (n, 2)."""
    turn = 2.0 * np.pi * rate_hz * t_s
    return csr_array(np.stack([np.sin(turn), np.cos(turn)], axis=1))


def two_way(covariate: FloatArray, basis: csr_array) -> csr_array:
    """A basis that changes sign with the way its covariate came."""
    return csr_array(diags_array(way(covariate)) @ basis)


def way(covariate: FloatArray) -> FloatArray:
    """+1 or -1: which way the covariate last moved by more than a little; 0 before it did."""
    reach = ESTIMATION.least_move * float(np.ptp(covariate))
    ways = np.zeros(len(covariate))
    anchor, last = float(covariate[0]), 0.0
    for k, value in enumerate(covariate.tolist()):
        if abs(value - anchor) > reach:
            last = 1.0 if value > anchor else -1.0
            anchor = value - last * reach
        ways[k] = last
    return ways


def _varies(covariate: FloatArray) -> bool:
    """Whether a covariate takes different values, not one with a ripple on it."""
    return bool(np.ptp(covariate) > ESTIMATION.least_travel * np.abs(covariate).max())


def spline_terms(model: Model, pieces: int = ESTIMATION.pieces) -> list[SplineTerm]:
    """Every input location with every covariate that makes sense there (`Traits.sensible`)."""
    shapes = []
    covariates, sensible = model.covariates(), traits_of(model).sensible
    knots = {name: knots_for(x, pieces) for name, x in covariates.items() if _varies(x)}
    bases = {name: spline_basis(covariates[name], k) for name, k in knots.items()}
    for location in model.inputs():
        for name, basis in bases.items():
            if sensible(location, name, pieces == ESTIMATION.pieces):
                shapes.append(SplineTerm(location, name, basis, knots[name]))
    return shapes


def way_shapes(model: Model) -> list[SplineTerm]:
    """Each location over its own place and the way it was come to."""
    covariates, shapes = model.covariates(), []
    own_place = traits_of(model).own_place
    for location in model.inputs():
        name = own_place.get(location, "")
        if name in covariates and _varies(covariates[name]):
            knots = knots_for(covariates[name])
            free = SplineTerm(location, name, csr_array((0, 0)), knots, "way")
            shapes.append(replace(free, basis=free.basis_for(covariates[name])))
    return shapes
