"""Beside a stop: what it blurs is near where it acts, and only there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.api import diagnose_recordings
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.noise import estimate
from deltactl.diagnosis.evidence.noise_estimation import prepare
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.priors.options import OPTIONS, PENALTIES
from deltactl.diagnosis.priors.penalties import penalty, penalty_of, spline_penalty
from deltactl.diagnosis.search.outside_contact import (
    clear_rows,
    gain_elsewhere,
    left_alone,
)
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.nonparametric import seen_apart
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
HEIGHT_M = -0.44


def _stop() -> EffectEntry:
    return EffectEntry(effect="contact", component="platform", parameters={"height": HEIGHT_M})


def _fitter(model: DeltaModel) -> Fitter:
    readings = model.readings
    left = np.nan_to_num(readings.values) - model.predict([n.term for n in model.nuisances])
    return Fitter(model, estimate(readings, readings.valid, left), model.nuisances)


def _term(model: DeltaModel, key: tuple[str, str], at: list[float]) -> Term:
    return Term(next(one for one in model.candidates if one.key == key), np.array(at))


def test_readings_are_left_alone_where_the_platform_is_not_near_the_stop(
    delta: DeltaRobot, record: Record
) -> None:
    model = DeltaModel(delta, [record(_stop(), seconds=30.0)])
    fitter = _fitter(model)
    stop = _term(model, ("contact", "platform"), [HEIGHT_M, 0.0])
    solution = fitter.solve((stop,))
    clear = left_alone(fitter, solution)
    sample = fitter.whiten.rows
    pressed = model.position_m[:, 2] < HEIGHT_M - 1e-3
    assert 0.02 < pressed.mean() < 0.5
    assert not clear[pressed[sample]].any()
    pressed_s = model.readings.t_s[pressed]
    apart_s = np.abs(model.readings.t_s[sample][:, None] - pressed_s).min(axis=1)
    assert clear[apart_s > OPTIONS.around_contact_s + 0.2].all()
    assert gain_elsewhere(fitter, solution, solution) == pytest.approx(0.0, abs=1e-6)


def test_without_a_stop_all_readings_count(delta: DeltaRobot, record: Record) -> None:
    model = DeltaModel(delta, [record(seconds=10.0)])
    fitter = _fitter(model)
    empty = fitter.solve(())
    assert clear_rows(fitter, empty, empty).all()


@pytest.mark.study
def test_what_is_small_beside_a_stop_is_found(delta: DeltaRobot, record: Record) -> None:
    """Its gain is less than what a stop that is not quite right may leave."""
    rings = EffectEntry(
        effect="resonance", component="platform", parameters={"frequency": 6.5, "damping": 0.1}
    )
    found = diagnose_recordings(delta, [record(_stop(), rings, seconds=45.0)]).findings
    assert {(one.effect, one.component) for one in found} == {
        ("contact", "platform"),
        ("resonance", "platform"),
    }


@pytest.mark.study
@pytest.mark.parametrize("everywhere", [False, True])
def test_a_shape_beside_a_stop_shows_where_that_does_not_act(
    delta: DeltaRobot, record: Record, everywhere: bool
) -> None:
    recording = record(_stop(), seconds=30.0)
    z_m = recording.columns["range_z"]
    sag_m = 0.004 * np.sin(9.0 * (z_m - z_m.max()))
    lowest = np.quantile(z_m, [0.0, 1.0])[0] + 0.01
    recording.columns["range_y"] += np.where(everywhere | (z_m < lowest), sag_m, 0.0)
    model = DeltaModel(delta, [recording])
    search = Search(prepare(model, model.readings.valid.copy()), 0.0)
    solution = search.fitter.solve((_term(model, ("contact", "platform"), [HEIGHT_M, 0.0]),))
    free = next(
        free
        for free, _, _ in search.tests.fine_scores(solution)
        if (free.location, free.covariate) == ("range_y", "range_z")
    )
    shaped = search.fitter.solve(solution.terms, (free,), solution.nuisances)
    assert solution.cost - shaped.cost > spline_penalty(free)
    assert seen_apart(search, solution, shaped) == everywhere


@pytest.mark.parametrize(
    ("key", "at", "only"),
    [
        (("gear_backlash", "motor1"), [0.0, 2.0, 0.0], True),
        (("gear_backlash", "motor1"), [0.004, 2.0, 0.0], False),
        (("resonance", "platform"), [np.log(9.0), 0.45], True),
        (("resonance", "platform"), [np.log(9.0), 0.1], False),
    ],
)
def test_an_effect_in_name_only_costs_like_any_shape(
    delta: DeltaRobot, record: Record, key: tuple[str, str], at: list[float], only: bool
) -> None:
    term = _term(DeltaModel(delta, [record(seconds=2.0)]), key, at)
    assert penalty_of(term) - penalty(term.candidate) == (PENALTIES.in_name_only if only else 0.0)
