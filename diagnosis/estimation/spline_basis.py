"""Free shapes over one covariate: cubic B-splines less what named shapes already span."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from diagnosis.observations.readings import FloatArray

DEGREE = 3
FEWEST_ROWS_A_PIECE = 8


def spline_basis(covariate: FloatArray, pieces: int, low: float, high: float) -> FloatArray:
    """Basis (n, pieces + 3) over equal pieces from low to high; constant beyond the ends."""
    if not high > low:
        return np.zeros((len(covariate), 0))
    inner = np.linspace(low, high, pieces + 1)
    knots = np.concatenate([[low] * DEGREE, inner, [high] * DEGREE])
    inside = np.clip(covariate, low, high)
    basis: FloatArray = BSpline.design_matrix(inside, knots, DEGREE).toarray()
    return basis


def orthogonal_to(basis: FloatArray, spanned: FloatArray, rows: FloatArray) -> FloatArray:
    """The basis (n, k) less its projection on `spanned` (n, j) over some rows, unit variance.

    So a free shape cannot take the place of a named one (Plumlee 2017, J. Am. Stat. Assoc. 112,
    1274-1285). Directions that vanish are left out.
    """
    if not basis.shape[1]:
        return basis
    share, *_ = np.linalg.lstsq(spanned[rows], basis[rows], rcond=1e-10)
    left = basis - spanned @ share
    _, size, across = np.linalg.svd(left[rows], full_matrices=False)
    kept = size > 1e-6 * max(float(size[0]), 1e-300)
    turned = left @ across[kept].T
    spread = np.std(turned[rows], axis=0)
    shapes: FloatArray = turned / np.maximum(spread, 1e-300)
    return shapes
