"""What a fit of everything takes out of the noise is given back; fine shapes score as they must."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.answer.verdict import ALARM
from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.estimation.estimate import orthonormal
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.noise import Whitener, estimate
from deltactl.diagnosis.evidence.detection import Detection
from deltactl.diagnosis.evidence.noise_estimation import prepare
from deltactl.diagnosis.evidence.options import EVIDENCE
from deltactl.diagnosis.evidence.saturated_model import Saturated, given_back
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.score_tests.fine_scores import scores_of
from deltactl.diagnosis.score_tests.score_test import explained_by
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
RHO = 0.6


def memory(whiten: Whitener) -> float:
    """Correlation from reading to reading, by Yule and Walker, mean of the channels."""
    return float(np.mean([n.phi[0] / (1.0 - n.phi[1]) for n in whiten.channels]))


@pytest.mark.study
def test_memory_and_spread_are_given_back(delta: DeltaRobot, record: Record) -> None:
    model = DeltaModel(delta, [record(rho=RHO, seconds=60.0)])
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


def test_a_constant_in_a_channel_is_no_noise(delta: DeltaRobot, record: Record) -> None:
    """A sensor that reads 20 mm off had its readings clipped to one value: a memory of seconds."""
    model = DeltaModel(delta, [record(rho=RHO, seconds=20.0)])
    residual = model.readings.values - model.predict([n.term for n in model.nuisances])
    valid = model.readings.valid
    plain = estimate(model.readings, valid, residual)
    moved = estimate(model.readings, valid, residual + np.array([0.02, -0.03, 0.5]))
    for one, other in zip(plain.channels, moved.channels, strict=True):
        assert other.phi == pytest.approx(one.phi, abs=1e-6)
        assert other.sigma == pytest.approx(one.sigma, rel=1e-6)
    assert moved.weight == pytest.approx(plain.weight, abs=1e-5)


@pytest.mark.study
def test_a_memory_that_is_a_mismatch_is_not_made_longer(delta: DeltaRobot, record: Record) -> None:
    model = DeltaModel(delta, [record()])
    prepared = prepare(model, model.readings.valid.copy())
    fit = Saturated(prepared.library, prepared.fitter)
    swaying = np.cumsum(np.random.default_rng(3).standard_normal((len(fit.fitter.observed), 3)), 0)
    long = estimate(model.readings, prepared.valid, 1e-4 * swaying)
    assert all(n.phi.sum() > EVIDENCE.longest_memory for n in long.channels)
    given, _ = given_back(fit, long, prepared.valid)
    for before, after in zip(long.channels, given.channels, strict=True):
        assert np.array_equal(before.phi, after.phi)


@pytest.mark.parametrize(
    ("seconds", "rho", "seed"),
    [(10.0, 0.4, 1), pytest.param(10.0, 0.4, 5, marks=pytest.mark.study), (6.0, 0.0, 1)],
)
def test_a_short_healthy_recording_raises_no_alarm(
    delta: DeltaRobot, record: Record, seconds: float, rho: float, seed: int
) -> None:
    """A third of them did, with p down to 1e-16: the fit of everything took most of the noise."""
    assert delta.drive is not None
    model = DeltaModel(delta, [record(seconds=seconds, rho=rho, seed=seed)])
    prepared = prepare(model, model.readings.valid.copy())
    assert Saturated(prepared.library, prepared.fitter).is_cut
    assert Detection(prepared, delta.drive.rad_per_step).first_p() > 3.0 * ALARM


@pytest.mark.study
def test_a_fault_still_shows_in_ten_seconds(delta: DeltaRobot, record: Record) -> None:
    home = EffectEntry(effect="home_offset", component="motor2", parameters={"angle": 0.01})
    answer = diagnose_recordings(delta, [record(home, seconds=10.0)])
    found = answer.findings[0]
    names = {(one.effect, one.component) for one in (found, *found.alternatives)}
    assert ("home_offset", "motor2") in names


@pytest.mark.study
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
