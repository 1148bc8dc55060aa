"""Spline terms over one covariate: cubic B-splines less what named shapes already span."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from deltactl.diagnosis.observations.readings import FloatArray, IntArray
from deltactl.diagnosis.plants.options import SPLINE_TERMS


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
