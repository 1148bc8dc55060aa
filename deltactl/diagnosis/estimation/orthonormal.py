"""An orthonormal basis of tall columns, some of which may be nearly the same."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.observations.readings import FloatArray


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
