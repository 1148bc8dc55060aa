"""Sizes told apart by a faint bend get the interval of what the fit loses, not of its slope."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from deltactl.diagnosis.assessment import intervals
from deltactl.diagnosis.assessment.intervals import covariance
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.noise import estimate
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]


def _fitted(
    delta: DeltaRobot, recording: FlatRecording, effect: str, at: list[float]
) -> tuple[Fitter, Solution]:
    model = DeltaModel(delta, [recording])
    candidate = next(c for c in model.candidates if c.effect == effect)
    term = Term(candidate, np.array(at))
    left = model.readings.values - model.predict([*(n.term for n in model.nuisances), term])
    whitener = estimate(model.readings, model.readings.valid, np.nan_to_num(left))
    fitter = Fitter(model, whitener, model.nuisances)
    return fitter, fitter.solve([term])


def test_the_rim_of_the_interval_is_where_the_fit_loses_what_95_percent_allow(
    delta: DeltaRobot, record: Record
) -> None:
    truth = {"strain": 0.004, "time_constant": 40.0}
    warm = EffectEntry(effect="thermal_expansion", component="arms", parameters=dict(truth))
    recording = record(warm, seconds=30.0)
    fitter, solution = _fitted(delta, recording, "thermal_expansion", [0.004, np.log(40.0)])
    part = solution.columns_of(0)
    found = intervals.by_profile(fitter, solution, 0, covariance(fitter, solution)[part, part])
    assert found is not None
    for name, (low, high) in found.items():
        assert low < truth[name] < high
    at, (low, high) = float(solution.terms[0].at[0]), found["strain"]
    half = 1.96 * float(np.sqrt(covariance(fitter, solution)[part, part][0, 0]))
    straight = np.array([at - half, at + half])
    assert np.abs(np.array([low, high]) - straight).max() > 0.2 * half
    held = intervals._held(solution.terms[0], 0, low)
    assert fitter.solve([held]).cost - solution.cost > 0.7 * intervals.LOSS_95


def test_sizes_that_are_sharp_keep_the_plain_interval(delta: DeltaRobot, record: Record) -> None:
    tilt = EffectEntry(effect="home_offset", component="motor1", parameters={"angle": 0.01})
    fitter, solution = _fitted(delta, record(tilt, seconds=30.0), "home_offset", [0.01])
    assert intervals.by_profile(fitter, solution, 0, np.array([[1e-8]])) is None
