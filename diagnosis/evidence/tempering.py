"""The noise of a regression plant: what a saturated set leaves, by its effective number.

The saturated set has every named shape and spline terms over each covariate. What even that leaves
is measurement noise and model discrepancy; both are in the likelihood.
"""

from __future__ import annotations

import numpy as np

from diagnosis.estimation.effective_size import TemperedNoise, runs_of_one_value, tempered
from diagnosis.evidence.laplace import Explanation, Laplace
from diagnosis.observations.readings import FloatArray
from diagnosis.plants.regression import RegressionPlant

TEMPERING_ROUNDS = 3
LEAST_NOISE_SHARE = 1e-6
"""No likelihood is believed to this share of the mismatch or less."""


def saturated_noise(plant: RegressionPlant) -> TemperedNoise:
    """From the saturated set, beginning with the whole mismatch as noise."""
    keys = frozenset(r.key for r in plant.regressors if r.saturated and not r.left_over)
    residual = plant.observed - plant.base(frozenset(), {})
    noise = _of(plant, residual, 0)
    for _ in range(TEMPERING_ROUNDS):
        fit = Laplace(plant, noise.untempered)(keys)
        noise = _of(plant, fit.residual, fit.tangent.shape[1])
    return noise


def noise_beyond(
    plant: RegressionPlant, best: Explanation, left_over: bool = False
) -> TemperedNoise:
    """The same once a better set is known: with everything in it, or spline terms, as well."""
    wide = {r.key for r in plant.regressors if r.left_over if left_over}
    wide |= {r.key for r in plant.regressors if r.saturated and not r.left_over and not left_over}
    keys = frozenset(wide) | best.keys
    noise = _of(plant, best.residual, best.tangent.shape[1])
    fit = Laplace(plant, noise.untempered)(keys, [best])
    return _of(plant, fit.residual, fit.tangent.shape[1])


def _of(plant: RegressionPlant, residual: FloatArray, fitted: int) -> TemperedNoise:
    mismatch = (plant.observed - plant.base(frozenset(), {}))[plant.rows]
    least = max(LEAST_NOISE_SHARE * float(np.std(mismatch)), plant.rounding, 1e-15)
    rounded = plant.rounding > 0.0
    once = runs_of_one_value(plant.observed, plant.groups, plant.rows) if rounded else None
    return tempered(residual, plant.rows, plant.groups, plant.kinds, least, fitted, once)
