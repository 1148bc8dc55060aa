"""What counts as a test, and what size the tests would have found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import chdtri

from deltactl.diagnosis.answer.verdict import ALARM
from deltactl.diagnosis.assessment.detection_limits import limits
from deltactl.diagnosis.evidence.detection import Detection
from deltactl.diagnosis.evidence.noise_estimation import Prepared, prepare
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.search.search import Search
from deltactl.models.robot import DeltaRobot, EffectEntry
from tests.diagnosis.conftest import Record

PROMPT_S = 0.0097
"""A reading is the mean of 20 ms: so much sooner, nothing of it is late."""


@pytest.fixture(scope="module")
def prepared(delta: DeltaRobot, record: Record) -> Prepared:
    model = DeltaModel(delta, [record(seconds=30.0)])
    return prepare(model, model.readings.valid)


@pytest.mark.study
def test_a_scan_that_did_not_run_is_no_test(prepared: Prepared) -> None:
    angles, steps = Detection(prepared, 0.0), Detection(prepared, 1e-4)
    assert angles.event_tests == 0.0
    assert steps.event_tests == pytest.approx(3.0 * prepared.model.readings.span_s)
    assert angles.p(-20.0) < steps.p(-20.0)


@pytest.mark.study
def test_the_smallest_size_grows_with_what_makes_a_score_scatter(prepared: Prepared) -> None:
    """Four times the variance needs twice the size, as four times the noise would."""
    search = Search(prepared, 0.0)
    sizes = {(s.effect, s.component): s.value for s in limits(search.tests)[1]}
    scorer = prepared.scorer
    before = scorer.variance_inflation
    try:
        scorer.variance_inflation = 4.0 * before
        larger = {(s.effect, s.component): s.value for s in limits(search.tests)[1]}
    finally:
        scorer.variance_inflation = before
    assert larger["home_offset", "motor1"] == pytest.approx(
        2.0 * sizes["home_offset", "motor1"], rel=0.01
    )


def test_four_in_five_scores_of_the_smallest_size_raise_the_alarm(prepared: Prepared) -> None:
    """Scores drawn with the effect in them, where nothing makes them scatter more than noise."""
    plain = replace(prepared)
    scorer = plain.scorer
    kept = scorer.variance_inflation, scorer.tolerance_factor
    scorer.variance_inflation, scorer.tolerance_factor = (
        np.ones_like(kept[0]),
        np.ones_like(kept[1]),
    )
    try:
        search = Search(plain, 0.0)
        smallest = {(s.effect, s.component): s.value for s in limits(search.tests)[1]}
        number = next(i for i, e in enumerate(plain.library.entries) if e.key[0] == "home_offset")
        component = plain.library.entries[number].key[1]
        (information,) = search.tests.scores_of_empty.information[number].ravel()
    finally:
        scorer.variance_inflation, scorer.tolerance_factor = kept
    mean = smallest["home_offset", component] * np.sqrt(information)
    drawn = (mean + np.random.default_rng(5).standard_normal(20_000)) ** 2
    alarm = chdtri(1, ALARM / (search.tests.calibration.tests + search.tests.event_tests))
    assert np.mean(drawn > alarm) == pytest.approx(0.8, abs=0.02)


@pytest.mark.study
def test_a_delay_that_is_always_fitted_takes_its_share_before_a_latency_is_seen(
    delta: DeltaRobot, record: Record
) -> None:
    """Readings that are as prompt as can be: the fitted delay stands at nothing, and can rise."""

    def tested(late_s: float, seed: int) -> Detection:
        entry = EffectEntry(
            effect="sensor_latency", component="sensors", parameters={"time": late_s}
        )
        recording = record(entry, seconds=20.0, seed=seed)
        for name in ("range_x", "range_y", "range_z"):
            values, t_s = recording.columns[name], recording.t_s
            recording.columns[name] = np.interp(t_s + PROMPT_S, t_s, values)
        model = DeltaModel(delta, [recording])
        return Detection(prepare(model, model.readings.valid), 0.0)

    prompt = tested(0.0, 1)
    assert prompt.empty.nuisances[0].at[0] == 0.0
    (size,) = [s.value for s in limits(prompt)[1] if s.effect == "sensor_latency"]
    assert size > prompt.prepared.model.readings.period_s
    assert tested(size, 2).first_p() <= ALARM
