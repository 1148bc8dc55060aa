"""The noise of a regression plant: what a saturated set leaves, by its effective number.

The saturated set has every named shape and spline terms over each covariate. What even that leaves
is measurement noise and model discrepancy; both are in the likelihood.
"""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.evidence.effective_size import (
    Rows,
    TemperedNoise,
    runs_of_one_value,
    tempered,
)
from deltactl.diagnosis.evidence.explanation import Explanation
from deltactl.diagnosis.evidence.laplace import Laplace
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.observations.readings import FloatArray
from deltactl.diagnosis.plants.regression import RegressionPlant


def saturated_noise(plant: RegressionPlant) -> TemperedNoise:
    """From the saturated set at its optimum, beginning with what changes from row to row.

    Beginning with the whole model error as noise, priors hold the sizes back, and what they hold
    back stays noise.
    """
    keys = frozenset(r.key for r in plant.regressors if r.saturated and not r.left_over)
    noise = _of_residual(plant, _fast_part(plant))
    fits = None
    for _ in range(EVIDENCE.tempering_rounds):
        fits = Laplace(plant, noise.untempered, fits)
        noise = _of(plant, fits(keys))
    return noise


def noise_beyond(
    plant: RegressionPlant, best: Explanation, left_over: bool = False
) -> TemperedNoise:
    """The same once a better set is known: with everything in it, or spline terms, as well."""
    wide = {r.key for r in plant.regressors if r.left_over if left_over}
    wide |= {r.key for r in plant.regressors if r.saturated and not r.left_over and not left_over}
    keys = frozenset(wide) | best.keys
    fit = Laplace(plant, _of(plant, best).untempered)(keys, [best])
    return _of(plant, fit, left_over)


def _fast_part(plant: RegressionPlant) -> FloatArray:
    """Second differences (n,) of the model error from row to row, as large as white noise in it."""
    mismatch = plant.observed - plant.base(frozenset(), {})
    fast = np.zeros(len(mismatch))
    inner = plant.rows[1:-1]
    fast[inner] = np.diff(mismatch[plant.rows], 2) / np.sqrt(6.0)
    return fast


def _of(plant: RegressionPlant, fit: Explanation, left_over: bool = False) -> TemperedNoise:
    """Noise of what a fit leaves. What it took of noise with a memory is given back where that is
    seen: under spline terms, which follow anything slow, and of sensors that average their
    readings. What a chain of nonlinear parts leaves of an encoder's reading is discrepancy, which
    no fit takes.
    """
    took = fit.tangent if left_over or plant.averages else None
    return _of_residual(plant, fit.residual, fit.tangent.shape[1], took)


def _of_residual(
    plant: RegressionPlant, residual: FloatArray, fitted: int = 0, took: FloatArray | None = None
) -> TemperedNoise:
    expected, rows, groups = plant.base(frozenset(), {}), plant.rows, plant.groups
    digits = EVIDENCE.digits * float(np.std((plant.observed + plant.drawn_on)[rows]))
    least = max(plant.rounding, digits, 1e-15)
    rounded = plant.rounding > 0.0
    once = runs_of_one_value(plant.observed, expected, groups, rows) if rounded else None
    asked = None if plant.asked is None else plant.asked[rows]
    course = (plant.unsampled, asked, plant.asked_rounding)
    read = Rows(rows, groups, plant.kinds, plant.noises, least, once, *course)
    return tempered(residual, read, fitted, took)
