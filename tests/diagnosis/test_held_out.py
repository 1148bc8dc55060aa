"""Held-out figures and intervals by what is known of them beforehand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from deltactl.diagnosis.assessment.holdout import on_another_run, on_blocks
from deltactl.diagnosis.assessment.intervals import NORMAL_95, covariance, parameters
from deltactl.diagnosis.assessment.options import ASSESSMENT
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.noise import ChannelNoise, Whitener
from deltactl.diagnosis.estimation.splines import SplineTerm, knots_for, spline_basis
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.priors import tolerances
from deltactl.models.robot import DeltaRobot
from deltactl.recording.tables.flat import FlatRecording
from tests.diagnosis.conftest import Record

SIGMA_M = 0.002
CHANNELS = [0, 1, 2]


@pytest.fixture(scope="module")
def recording(record: Record) -> FlatRecording:
    made = record(seconds=30.0, rho=0.0)
    # A clock that ran before, as clocks do.
    return replace(made, t_s=made.t_s + 1000.0)


@pytest.fixture(scope="module")
def model(delta: DeltaRobot, recording: FlatRecording) -> DeltaModel:
    return DeltaModel(delta, [recording])


def fitter_of(model: DeltaModel) -> Fitter:
    """White noise of 2 mm in each channel."""
    last = np.arange(2, len(model.readings.t_s))
    noise = ChannelNoise(
        np.stack([last, last - 1, last - 2], axis=1), np.zeros(2), SIGMA_M, SIGMA_M
    )
    return Fitter(model, Whitener((noise,) * 3, np.ones(3 * len(last))), model.nuisances)


def term_of(model: DeltaModel, effect: str, component: str, size: float) -> Term:
    (candidate,) = (
        one for one in model.candidates if (one.effect, one.component) == (effect, component)
    )
    return Term(candidate, np.array([size, *candidate.shapes[0].origin[1:]]))


def changed(
    delta: DeltaRobot, recording: FlatRecording, rows: np.ndarray, by_m: float
) -> DeltaModel:
    columns = {name: values.copy() for name, values in recording.columns.items()}
    for axis in "xyz":
        columns[f"range_{axis}"][rows] += by_m
    return DeltaModel(delta, [FlatRecording(recording.t_s, columns, {}, "changed")])


def held_rows(recording: FlatRecording) -> np.ndarray:
    t_s = recording.t_s
    block = np.minimum(
        ((t_s - t_s[0]) / np.ptp(t_s) * ASSESSMENT.blocks).astype(int), ASSESSMENT.blocks - 1
    )
    return block % ASSESSMENT.every == ASSESSMENT.every // 2


def fitted(model: DeltaModel) -> tuple[Fitter, Solution, Solution]:
    fitter = fitter_of(model)
    named = fitter.solve((term_of(model, "home_offset", "motor1", 0.0),), (), None)
    return fitter, fitter.solve((), (), None), named


def test_blocks_that_are_held_out_take_no_part_in_the_fit(
    delta: DeltaRobot, recording: FlatRecording, model: DeltaModel
) -> None:
    """What is wrong in them alone stays in the figure as a whole; a fit of them takes some off."""
    rows = held_rows(recording)
    other = changed(delta, recording, rows, 0.05)
    _, after = on_blocks(*fitted(other), model.readings.valid, CHANNELS)
    assert after == pytest.approx(0.05, rel=0.02)


def test_what_is_wrong_in_the_fitted_blocks_is_in_no_held_out_figure(
    delta: DeltaRobot, recording: FlatRecording, model: DeltaModel
) -> None:
    other = changed(delta, recording, ~held_rows(recording), 0.05)
    before, _ = on_blocks(*fitted(other), model.readings.valid, CHANNELS)
    clean, _ = on_blocks(*fitted(model), model.readings.valid, CHANNELS)
    # The figure is of clean readings; what the fit of the others carries over is small.
    assert before < 0.02
    assert clean < 0.02


def test_events_do_not_come_back_in_another_run(
    delta: DeltaRobot, recording: FlatRecording, model: DeltaModel
) -> None:
    fitter, _, solution = fitted(model)
    candidate = solution.terms[0].candidate
    event = replace(candidate, kind=replace(candidate.kind, event=True))
    with_event = replace(solution, terms=(Term(event, np.array([0.3])),))
    another = DeltaModel(delta, [recording])
    before, after = on_another_run(another, fitter.solve((), (), None), with_event, CHANNELS)
    assert after == pytest.approx(before, rel=0.01)
    lasting = replace(solution, terms=(Term(candidate, np.array([0.3])),))
    assert on_another_run(another, solution, lasting, CHANNELS)[1] > 10.0 * before


def test_unknowns_that_depend_on_something_come_back_in_another_run(
    delta: DeltaRobot, recording: FlatRecording, model: DeltaModel
) -> None:
    """Two of them, each by its own numbers: a run in which they act the same way is foretold."""
    covariates, inputs = model.covariates(), model.inputs()
    frees = []
    for place, name in (("motor1", "theta_1"), ("range_z", "theta_2")):
        knots = knots_for(covariates[name], 4)
        frees.append(SplineTerm(place, name, spline_basis(covariates[name], knots), knots))
    found = fitter_of(model).solve((), tuple(frees), None)
    sizes = 0.02 * np.arange(1.0, frees[0].size + frees[1].size + 1.0)
    read = model.predict(found.nuisances)
    for free, own in zip(frees, np.split(sizes, [frees[0].size]), strict=True):
        read = read + free.columns(inputs[free.location]) @ own
    columns = recording.columns | {f"range_{axis}": read[:, i] for i, axis in enumerate("xyz")}
    another = DeltaModel(delta, [FlatRecording(recording.t_s, columns, {}, "another")])
    before, after = on_another_run(another, found, replace(found, coefficients=sizes), CHANNELS)
    assert before > 0.1
    assert after < 1e-6


def test_one_reading_that_leaps_does_not_make_another_run_look_bad(
    delta: DeltaRobot, recording: FlatRecording, model: DeltaModel
) -> None:
    fitter, _, solution = fitted(model)
    rows = np.zeros(len(recording), dtype=bool)
    rows[700] = True
    other = changed(delta, recording, rows, 0.4)
    empty = fitter.solve((), (), None)
    assert on_another_run(other, empty, solution, CHANNELS)[1] == pytest.approx(
        on_another_run(model, empty, solution, CHANNELS)[1], rel=0.01
    )


def test_noise_that_comes_in_blocks_widens_an_interval(model: DeltaModel) -> None:
    """The sandwich: whitened residuals with a common part in each block, by the textbook factor."""
    fitter, _, solution = fitted(model)
    rng = np.random.default_rng(0)
    blocks = fitter.blocks
    plain = rng.standard_normal(fitter.rows)
    common = rng.standard_normal(blocks.max() + 1)[blocks]
    rest = solution.residual[fitter.rows :]

    def spread(white: np.ndarray) -> float:
        cov = covariance(fitter, replace(solution, residual=np.concatenate([white, rest])))
        return float(np.sqrt(cov[-1, -1]))

    assert spread(plain + common) > 1.5 * spread(plain)
    # A few blocks say how much is common only roughly: no more than three times.
    assert spread(100.0 * common) <= 3.0 * spread(np.zeros(fitter.rows))


def test_no_interval_is_finer_than_the_best_machine(
    model: DeltaModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tolerances that no robot file can promise, of a home: at least 0.03 mrad either way."""
    fitter, _, solution = fitted(model)
    silent = replace(solution, residual=np.zeros_like(solution.residual))
    with_them = covariance(fitter, silent)
    monkeypatch.setattr(tolerances, "PENALTIES", replace(tolerances.PENALTIES, most_careful=0.0))
    without = covariance(fitter, silent)
    assert with_them[-1, -1] > without[-1, -1]


def test_an_interval_is_the_normal_one_around_its_value(model: DeltaModel) -> None:
    term = term_of(model, "home_offset", "motor1", 0.01)
    result = parameters(term, np.array([[1e-6]]))["angle"]
    assert result.value == pytest.approx(0.01)
    assert list(result.ci95) == pytest.approx([0.01 - NORMAL_95 * 1e-3, 0.01 + NORMAL_95 * 1e-3])
    assert pytest.approx(1.96, abs=1e-3) == NORMAL_95
