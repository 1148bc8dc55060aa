"""Does it hold up? RMS before and after on data the fit has not seen, against the noise floor."""

from __future__ import annotations

import numpy as np

from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.noise import Whitener
from deltactl.diagnosis.estimation.splines import SplineTerm
from deltactl.diagnosis.evidence.left_by_measured import held_to
from deltactl.diagnosis.observations.readings import BoolArray, FloatArray, without_outliers
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.contract import Model


def rms(residual: FloatArray, valid: BoolArray, columns: list[int]) -> float:
    """Root mean square over the valid values of some channels; 0 when there are none."""
    values = residual[:, columns][valid[:, columns]]
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def counted_columns(model: Model) -> tuple[list[int], str]:
    """Channels the RMS is taken over: those in metres, else all."""
    units = model.readings.units
    metres = [i for i, unit in enumerate(units) if unit == "m"]
    return (metres, "m") if metres else (list(range(len(units))), units[0])


def on_another_run(
    model: Model, empty: Solution, solution: Solution, columns: list[int]
) -> tuple[float, float]:
    """RMS before and after on another recording; events do not come back there."""
    lasting = [term for term in solution.terms if not term.candidate.kind.event]
    before = model.predict(empty.nuisances)
    after = model.predict([*solution.nuisances, *lasting]) + _free_part(model, solution)
    observed = np.nan_to_num(model.readings.values)
    valid = without_outliers(observed - after, model.readings.valid)
    return rms(observed - before, valid, columns), rms(observed - after, valid, columns)


def _free_part(model: Model, solution: Solution) -> FloatArray:
    total, first = np.zeros_like(model.readings.values), 0
    inputs, covariates = model.inputs(), model.covariates()
    for free in solution.frees:
        count = free.size
        basis = free.basis_for(covariates[free.covariate])
        part = solution.coefficients[first : first + count]
        total += inputs[free.location] * (basis @ part)[:, None]
        first += count
    return total


def on_blocks(
    fitter: Fitter, empty: Solution, solution: Solution, valid: BoolArray, columns: list[int]
) -> tuple[float, float]:
    """RMS before and after on whole blocks of time that a refit has not seen.

    What a robot file knows from earlier diagnoses is kept as the file has it (`empty`).
    """
    t_s = fitter.model.readings.t_s
    last = ASSESSMENT.blocks - 1
    block = np.minimum(((t_s - t_s[0]) / np.ptp(t_s) * ASSESSMENT.blocks).astype(int), last)
    held = block % ASSESSMENT.every == ASSESSMENT.every // 2
    white = fitter.whiten
    weight = np.where(held[white.rows], 0.0, white.weight)
    partial = Fitter(fitter.model, Whitener(white.channels, weight), fitter.nuisances)
    before = empty if held_to(fitter) else _refit(partial, (), (), solution.nuisances)
    after = _refit(partial, solution.terms, solution.frees, solution.nuisances)
    observed = fitter.observed[held]
    return (
        rms(observed - before.predicted[held], valid[held], columns),
        rms(observed - after.predicted[held], valid[held], columns),
    )


def _refit(
    fitter: Fitter,
    terms: tuple[Term, ...],
    frees: tuple[SplineTerm, ...],
    nuisances: tuple[Term, ...],
) -> Solution:
    start = nuisances if terms or frees else None
    return fitter.solve(terms, frees, start, steps=3)
