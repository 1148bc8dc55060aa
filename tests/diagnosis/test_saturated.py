"""What a fit of everything takes out of the noise is given back; fine shapes score as they must."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from diagnosis.estimation.least_squares import Fitter
from diagnosis.estimation.noise import Whitener, estimate
from diagnosis.estimation.orthonormal import orthonormal
from diagnosis.evidence.noise_estimation import prepare
from diagnosis.evidence.saturated_model import LONGEST, Saturated, given_back
from diagnosis.plants.delta.model import DeltaModel
from diagnosis.score_tests.fine_scores import scores_of
from diagnosis.score_tests.score_test import explained_by
from models.robot import DeltaRobot
from recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
RHO = 0.6


def memory(whiten: Whitener) -> float:
    """Correlation from reading to reading, by Yule and Walker, mean of the channels."""
    return float(np.mean([n.phi[0] / (1.0 - n.phi[1]) for n in whiten.channels]))


def test_memory_and_spread_are_given_back(delta: DeltaRobot, record: Record) -> None:
    model = DeltaModel(delta, [record(rho=RHO)])
    prepared = prepare(model, model.readings.valid.copy())
    fit = Saturated(prepared.library, prepared.fitter)
    still = model.predict([n.term for n in model.nuisances])
    residual = prepared.fitter.observed - still
    taken = estimate(model.readings, prepared.valid, residual - fit(residual))
    given, larger = given_back(fit, taken, prepared.valid)
    truly = memory(estimate(model.readings, prepared.valid, residual))
    assert memory(taken) < truly - 0.02
    assert memory(given) == pytest.approx(truly, abs=0.01)
    assert np.all(larger > 1.0)
    sigmas = [[n.sigma for n in whiten.channels] for whiten in (taken, given)]
    assert np.all(np.array(sigmas[1]) > np.array(sigmas[0]))


def test_a_memory_that_is_a_mismatch_is_not_made_longer(delta: DeltaRobot, record: Record) -> None:
    model = DeltaModel(delta, [record()])
    prepared = prepare(model, model.readings.valid.copy())
    fit = Saturated(prepared.library, prepared.fitter)
    swaying = np.cumsum(np.random.default_rng(3).standard_normal((len(fit.fitter.observed), 3)), 0)
    long = estimate(model.readings, prepared.valid, 1e-4 * swaying)
    assert all(n.phi.sum() > LONGEST for n in long.channels)
    given, _ = given_back(fit, long, prepared.valid)
    for before, after in zip(long.channels, given.channels, strict=True):
        assert np.array_equal(before.phi, after.phi)


def test_fine_shapes_score_as_dense_columns_would(delta: DeltaRobot, record: Record) -> None:
    model = DeltaModel(delta, [record()])
    prepared = prepare(model, model.readings.valid.copy())
    fitter: Fitter = prepared.fitter
    solution = fitter.solve(())
    basis = orthonormal(solution.tangent)
    shapes = prepared.fine[:3] + prepared.fine[-2:]
    for free, gain, _ in scores_of(shapes, fitter, solution, prepared.small):
        columns = fitter.vector(free.columns(model.inputs()[free.location]))
        left = columns - basis @ (basis.T @ columns)
        dense, _ = explained_by(left, solution.residual)
        assert gain == pytest.approx(dense, rel=1e-4)
