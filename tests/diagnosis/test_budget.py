"""The search ends at its limit of work: with the best it has, and the same on any machine."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from contextvars import Context
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.diagnosis.estimation.budget import Budget, Until
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.estimation.side_by_side import alone
from deltactl.diagnosis.evidence.noise_estimation import prepare
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.selection.model_choice import explain
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
SCALE = EffectEntry(effect="sensor_scale", component="range_x", parameters={"scale": 1.02})
RATIO = EffectEntry(effect="gear_ratio", component="motor2", parameters={"scale": 1.01})
ARM = EffectEntry(effect="upper_arm_length", component="arm1", parameters={"length_error": 0.006})


@given(st.lists(st.floats(0.0, 1e3), max_size=10), st.sampled_from(Until))
def test_it_lasts_until_its_share_is_spent(spent: list[float], until: Until) -> None:
    budget = Budget(most=1000.0)
    for one in spent:
        budget.spend(one)
    lasts = sum(spent) < until.value * 1000.0
    assert budget.lasts(until) is lasts
    assert budget.ended is not lasts


def test_a_short_recording_allows_more_predictions_and_a_long_one_no_fewer() -> None:
    usual = Budget.for_rows(ESTIMATION.rows_of_unit)
    assert Budget.for_rows(ESTIMATION.rows_of_unit // 2).most == 2.0 * usual.most
    assert Budget.for_rows(10 * ESTIMATION.rows_of_unit).most == usual.most


@pytest.mark.parametrize("here", [alone, nullcontext])
def test_each_task_begins_with_what_is_left_whoever_works_on_it(
    here: Callable[..., object],
) -> None:
    budget = Budget(most=100.0, spent=40.0)

    def task(work: float) -> tuple[float, bool]:
        before = budget.spent
        budget.spend(work)
        return before, budget.lasts(Until.GROWN)

    with here():  # type: ignore[attr-defined]
        found = budget.side_by_side([partial(task, w) for w in (5.0, 30.0, 1.0)])
    assert found == [(40.0, True), (40.0, False), (40.0, True)]
    assert budget.spent == 76.0
    assert budget.ended


def test_what_is_remembered_is_not_counted() -> None:
    budget = Budget(most=100.0, spent=3.0)
    with budget.not_counted():
        budget.spend(50.0)
    assert budget.spent == 3.0


@pytest.mark.study
def test_a_search_without_patience_ends_with_what_it_has(delta: DeltaRobot, record: Record) -> None:
    model = DeltaModel(delta, [record(SCALE, RATIO, ARM, seconds=60.0)])
    short, long = (
        explain(prepare(model, model.readings.valid.copy(), budget), 0.0, lambda _: None)
        for budget in (Budget(most=20.0), Budget())
    )
    few, many = ({t.candidate.key for t in one.solution.terms} for one in (short, long))
    assert many == {(one.effect, one.component) for one in (SCALE, RATIO, ARM)}
    assert few
    assert len(few) < len(many)
    spent = [one.search.budget for one in (short, long)]
    assert spent[0].ended
    assert not spent[1].ended
    assert spent[0].spent < 0.5 * spent[1].spent


@pytest.mark.study
def test_the_same_work_is_counted_on_one_core_and_on_two(delta: DeltaRobot, record: Record) -> None:
    model = DeltaModel(delta, [record(SCALE, RATIO, seconds=8.0)])
    counted = []
    for shared in (False, True):
        budget = Budget(most=150.0)
        Context().run(searched, model, budget, shared)
        counted.append((budget.spent, budget.ended))
    assert counted[0] == counted[1]


def searched(model: DeltaModel, budget: Budget, shared: bool) -> None:
    with nullcontext() if shared else alone():
        explain(prepare(model, model.readings.valid.copy(), budget), 0.0, lambda _: None)
