"""Spline terms over one covariate: cubic B-splines less what named shapes already span."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

from deltactl.diagnosis.answer.records import NotTestable
from deltactl.diagnosis.observations.largest_noise import (
    Bound,
    NoiseBounds,
    remembering,
    segment_for,
    spectrum,
)
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, IntArray, Readings
from deltactl.diagnosis.plants.options import SPLINE_TERMS
from deltactl.diagnosis.plants.regression import Columns, RegressionPlant, Regressor, Sizes


def spline_basis(covariate: FloatArray, pieces: int, low: float, high: float) -> FloatArray:
    """Basis (n, pieces + 3) over equal pieces from low to high; constant beyond the ends."""
    if not high > low:
        return np.zeros((len(covariate), 0))
    inner = np.linspace(low, high, pieces + 1)
    degree = SPLINE_TERMS.spline_degree
    knots = np.concatenate([[low] * degree, inner, [high] * degree])
    inside = np.clip(covariate, low, high)
    basis: FloatArray = BSpline.design_matrix(inside, knots, degree).toarray()
    return basis


def spline_over(covariate: FloatArray, pieces: int, rows: IntArray) -> FloatArray:
    """Splines of a covariate (n,) between nearly all of its values in some rows."""
    low, high = (float(x) for x in np.quantile(covariate[rows], SPLINE_TERMS.covered))
    return spline_basis(covariate, pieces, low, high)


def less_spanned(basis: FloatArray, spanned: FloatArray, rows: IntArray) -> FloatArray:
    """Shapes (n, k) less their projection on others (n, j) over some rows, of unit variance.

    So a spline term cannot take the place of a named one (Plumlee 2017, J. Am. Stat. Assoc. 112,
    1274-1285). Directions that vanish are left out, and those that are mostly the others':
    scaled up, the rest of one is the noise of a measured acceleration.
    """
    if not basis.shape[1]:
        return basis
    _, size, across = np.linalg.svd(basis[rows], full_matrices=False)
    seen = size > SPLINE_TERMS.vanishing * size.max(initial=1e-300)
    apart = basis @ (across[seen].T / size[seen])
    known, size, _ = np.linalg.svd(_scaled(spanned[rows]), full_matrices=False)
    known = known[:, size > SPLINE_TERMS.vanishing * size.max(initial=1e-300)]
    _, cosine, turned = np.linalg.svd(known.T @ apart[rows])
    own = np.ones(apart.shape[1], dtype=bool)
    own[: len(cosine)] = cosine**2 < SPLINE_TERMS.mostly
    shapes = apart @ turned[own].T
    share, *_ = np.linalg.lstsq(spanned[rows], shapes[rows], rcond=1e-10)
    left = shapes - spanned @ share
    unit: FloatArray = left / np.maximum(np.std(left[rows], axis=0), 1e-300)
    return unit


def _scaled(shapes: FloatArray) -> FloatArray:
    """Shapes (m, j) of one length, whatever their units."""
    unit: FloatArray = shapes / np.maximum(np.linalg.norm(shapes, axis=0), 1e-300)
    return unit


def carried_over(
    shape: FloatArray, known: FloatArray, pieces: int, elsewhere: FloatArray
) -> FloatArray:
    """A spline term (n,) as a function of its covariate alone, at other values of that (m,).

    Nothing is said beyond the values that were seen.
    """
    low, high = (float(x) for x in np.quantile(known, SPLINE_TERMS.covered))
    if not high > low:
        return np.zeros_like(elsewhere)
    size, *_ = np.linalg.lstsq(spline_basis(known, pieces, low, high), shape, rcond=1e-6)
    found: FloatArray = spline_basis(elsewhere, pieces, low, high) @ size
    return found * ((elsewhere >= low) & (elsewhere <= high))


class KeepsBeside:
    """A plant whose spline terms, kept in `_unknown`, give way to the shapes of a chosen set."""

    readings: Readings
    kinds: IntArray
    regressors: tuple[Regressor, ...]
    averages = False
    rounding = 0.0
    left_by_known: Sequence[tuple[float, FloatArray]] = ()
    done_by_known: FloatArray | None = None

    @cached_property
    def t_s(self) -> FloatArray:
        """As they were read."""
        return self.readings.t_s

    @cached_property
    def groups(self) -> IntArray:
        """One for each stretch."""
        return np.cumsum(self.readings.fresh).astype(np.intp)

    @cached_property
    def beside(self) -> FloatArray:
        """Shapes (n, j) of a chosen set: none yet."""
        return np.zeros((len(self.t_s), 0))

    @cached_property
    def drawn_on(self) -> FloatArray:
        """Nothing."""
        return np.zeros(len(self.t_s))

    @property
    def stays(self) -> IntArray:
        """Numbers of rests: none, as none is known."""
        return np.full(len(self.groups), -1, dtype=np.intp)

    @property
    def noises(self) -> IntArray:
        """One noise for each kind of row."""
        return self.kinds

    @property
    def usual(self) -> FloatArray | None:
        """Of one size."""
        return None

    @property
    def unsampled(self) -> FloatArray | None:
        """Nothing: the prediction does not depend on what happens between samples."""
        return None

    def not_testable(self) -> list[NotTestable]:
        """Nothing is out of reach of every recording of such a machine."""
        return []

    def noise_bounds(self, left: FloatArray) -> NoiseBounds | None:
        """Bounds of the noise in a residual (n,), where every row is read like its neighbours."""
        read = np.flatnonzero(self.readings.valid[:, 0])  # also rows that are thinned out
        seen = spectrum(left[read], self.groups[read], segment_for(len(read)))
        if seen is None:
            return None
        shapes = remembering(seen.angle)
        return NoiseBounds([Bound(seen, shapes)], np.ones(shapes.shape[1]))

    def base(self, keys: frozenset[str], sizes: Sizes) -> FloatArray:
        """Nothing is predicted but by columns, (n,)."""
        return np.zeros(len(self.groups))

    def free(self) -> Columns:
        """Nothing is free."""
        return Columns.none(len(self.t_s))

    def starts(self, key: str, residual: FloatArray) -> Sequence[dict[str, float]]:
        """Those of the regressor, whatever is left."""
        own = next(one for one in self.regressors if one.key == key)
        names = [f"{key}.{size.name}" for size in own.sizes]
        return [dict(zip(names, start, strict=True)) for start in own.starts]

    def impossible(
        self, keys: frozenset[str], sizes: Sizes, linear: Mapping[str, FloatArray]
    ) -> bool:
        """Whether a size lies at a bound of its regressor, or beyond."""
        for one in self.regressors:
            if one.key not in keys:
                continue
            if one.above > -math.inf and linear[one.key][0] <= one.above:
                return True
            each = ((size.within, sizes[f"{one.key}.{size.name}"]) for size in one.sizes)
            if any(not low < value < high for (low, high), value in each):
                return True
        return False

    @property
    def variant(self) -> RegressionPlant | None:
        """There is one way to prepare it."""
        return None

    def map_around(self, keys: frozenset[str], sizes: Sizes) -> None:
        """There is no map in detail."""

    def map_finely(self, keys: frozenset[str], sizes: Sizes, left: FloatArray) -> bool:
        """One detail of the spline terms is all there is."""
        return False

    def further_odds(self, keys: frozenset[str], linear: Mapping[str, FloatArray]) -> float:
        """None that hang on sizes."""
        return 0.0

    def without_noise(self, keys: frozenset[str], sizes: Sizes) -> BoolArray | None:
        """None."""
        return None

    def detail(self, key: str) -> int:
        """As any other."""
        return 0

    def begins(self, keys: frozenset[str]) -> list[str]:
        """A recording of a machine without play begins nowhere in it."""
        return []

    def keep_beside(self, shapes: FloatArray) -> None:
        """Spline terms must not take the place of these shapes (n, j) either."""
        self.beside = shapes
        self.__dict__.pop("_unknown", None)
