"""From a model to a fitter with a noise model: the noise comes from a saturated fit.

The residual of the whole library at once (every effect, every spline) holds hardly any model error,
whatever is wrong with the machine: its autocorrelation, spread and outliers are those of the
readings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.diagnosis.estimation.budget import Budget
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.noise import estimate
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.estimation.splines import SplineTerm, spline_terms, way_shapes
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.evidence.saturated_model import Saturated, given_back
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, without_outliers
from deltactl.diagnosis.plants.contract import Model
from deltactl.diagnosis.priors.tolerances import tolerance_columns
from deltactl.diagnosis.score_tests.library import Library, build
from deltactl.diagnosis.score_tests.score_test import Scorer, tolerance_factor


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """Everything the search needs."""

    model: Model
    fitter: Fitter
    library: Library
    scorer: Scorer
    valid: BoolArray
    fine: list[SplineTerm]
    """Finely resolved spline terms and those of place and way, tested apart from the library."""
    floor: FloatArray
    """Residual that the saturated fit leaves, (n, channels): the noise."""
    small: FloatArray | None = None
    """Whitened changes that build tolerances make, (m, k); None for single axes."""

    @property
    def shapes(self) -> list[SplineTerm]:
        """All spline terms, coarse and fine."""
        return [*(entry.free for entry in self.library.entries if entry.free), *self.fine]


def prepare(model: Model, valid: BoolArray, budget: Budget | None = None) -> Prepared:
    """Noise model, whitened library and scorer around the nominal machine.

    budget: how much the search that follows may be; without it, as much as there is to do.
    """
    fine = [*spline_terms(model, ESTIMATION.fine_pieces), *way_shapes(model)]
    predicted = model.predict([n.term for n in model.nuisances])
    return _prepared(model, valid, build(model), fine, predicted, EVIDENCE.noise_rounds, budget)


def once_more(before: Prepared, predicted: FloatArray) -> Prepared:
    """The same with noise and outliers by a better prediction, from a first round of naming."""
    budget = before.fitter.budget
    budget.spend(ESTIMATION.noise_work)
    return _prepared(before.model, before.valid, before.library, before.fine, predicted, 1, budget)


def _prepared(
    model: Model,
    valid: BoolArray,
    library: Library,
    fine: list[SplineTerm],
    predicted: FloatArray,
    rounds: int,
    budget: Budget | None,
) -> Prepared:
    readings = model.readings
    residual = np.nan_to_num(readings.values) - predicted
    valid = without_outliers(residual, valid)
    whitener = estimate(readings, valid, residual)
    for _ in range(rounds):
        fitter = Fitter(model, whitener, model.nuisances)
        library.whiten(fitter)
        fit = Saturated(library, fitter)
        left = residual - fit(residual)
        whitener = estimate(readings, valid, left)
    whitener, larger = given_back(fit, whitener, valid)
    fitter = Fitter(model, whitener, model.nuisances, budget)
    library.whiten(fitter)
    scorer = Scorer(library)
    scorer.variance_inflation = _variance_inflation(library, fitter, fitter.whiten(left))
    small = tolerance_columns(fitter, [n.term for n in model.nuisances])[: fitter.rows]
    by_tolerances = np.asarray(library.white.T @ small.astype(np.float32), dtype=np.float64)
    parts = [entry.columns for entry in library.entries]
    scorer.tolerance_factor = np.array(
        [tolerance_factor(scorer.gram[p, p], by_tolerances[p]) for p in parts]
    )
    return Prepared(model, fitter, library, scorer, valid, fine, left * larger, small)


def _variance_inflation(library: Library, fitter: Fitter, floor: FloatArray) -> FloatArray:
    """How much more the score of each entry scatters from block to block than white noise would."""
    blocks = fitter.blocks
    variance_inflation = np.ones(len(library.entries))
    for number, entry in enumerate(library.entries):
        column = library.white[:, entry.columns.start]
        sums = np.bincount(blocks, weights=column * floor)
        plain = float(column.astype(np.float64) @ column)
        if plain > 0.0:
            variance_inflation[number] = np.clip(float(sums @ sums) / plain, 1.0, 2.0)
    return variance_inflation
