"""Spline terms where build tolerances are held by priors, and where they make these idle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.evidence.noise_estimation import prepare
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.credible_set import _of_shape
from deltactl.diagnosis.selection.nonparametric import (
    explains_it_all,
    in_place_of,
    named_instead,
    shape_promises,
    with_spline_terms,
)
from deltactl.diagnosis.selection.tolerance_or_cause import ToleranceOrCause
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
SIZE_M = 0.03


@pytest.fixture(scope="module")
def loosely(delta: DeltaRobot, record: Record) -> ToleranceOrCause:
    """A sensor that is wrong by a wave of its own reading."""
    recording = record(seconds=60.0)
    seen = recording.columns["range_y"]
    turns = (seen - seen.min()) / np.ptp(seen)
    recording.columns["range_y"] = seen + SIZE_M * np.sin(2.5 * np.pi * turns) ** 3
    model = DeltaModel(delta, [recording])
    assert delta.drive is not None
    prepared = prepare(model, model.readings.valid.copy())
    return ToleranceOrCause(Search(prepared, delta.drive.rad_per_step))


@pytest.mark.study
def test_a_shape_that_takes_over_lets_tolerances_spring_back(loosely: ToleranceOrCause) -> None:
    other = loosely.other
    free, gain, _ = max(other.tests.fine_scores(other.tests.empty), key=lambda one: one[1])
    found = other.fitter.solve((), (free,), other.tests.empty.nuisances)
    held = other.fitter.rows
    assert np.sum(other.tests.empty.residual[held:] ** 2) > 2.0 * np.sum(found.residual[held:] ** 2)
    assert other.tests.empty.cost - found.cost == pytest.approx(gain, rel=0.05)


@pytest.mark.study
def test_a_shape_that_explains_it_all_needs_no_loosely_built_machine(
    loosely: ToleranceOrCause,
) -> None:
    search = loosely.search
    solution = search.run()
    told = search.criterion.fully_penalised(solution)
    assert shape_promises(search, solution, told)
    shaped = with_spline_terms(search, solution)
    assert [free.location for free in shaped.frees] == ["range_y"]
    assert explains_it_all(search, shaped, told)
    assert not explains_it_all(search, shaped, search.criterion.fully_penalised(shaped))
    assert not explains_it_all(search, solution, np.inf), "no shape explains anything here"


@pytest.mark.study
def test_a_named_effect_that_explains_better_takes_the_place_of_a_shape(
    delta: DeltaRobot, record: Record
) -> None:
    """And a shape that explains better is more probable than what could be named for it."""
    bent = EffectEntry(
        effect="sensor_crosstalk", component="range_z", parameters={"curvature": 0.03}
    )
    model = DeltaModel(delta, [record(bent, seconds=20.0)])
    search = Search(prepare(model, model.readings.valid.copy()), 1e-3)
    free = next(one for one in search.prepared.fine if one.location == one.covariate == "range_z")
    shaped = search.fitter.solve((), (free,), search.tests.empty.nuisances)
    assert _of_shape(search, shaped, free, in_place_of(search, shaped, free)) < 0.01
    named, _ = named_instead(search, shaped)
    assert [term.candidate.key for term in named.terms] == [("sensor_crosstalk", "range_z")]
    assert named.frees == ()


@pytest.mark.study
def test_a_shape_that_explains_better_than_any_name_stays(loosely: ToleranceOrCause) -> None:
    search = loosely.search
    shaped = with_spline_terms(search, search.run())
    stays, in_place = named_instead(search, shaped)
    assert stays is shaped
    assert all(_of_shape(search, shaped, free, in_place[free]) > 0.95 for free in shaped.frees)
