"""What no machine can have is no finding: it is taken out, and the rest is fitted again."""

from __future__ import annotations

from copy import copy

import numpy as np
import pytest

from deltactl.diagnosis.assessment import intervals
from deltactl.diagnosis.assessment.impossible import (
    beyond_physics,
    first_impossible,
    impossible,
    lacking,
    less,
)
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.evidence.noise_estimation import prepare
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.candidates import lost_steps
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.score_tests.change_points import jumps
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.ambiguity import stands_of
from deltactl.diagnosis.selection.credible_set import credible
from deltactl.diagnosis.selection.model_choice import Explained
from deltactl.models.robot import DeltaRobot, EffectEntry
from tests.diagnosis.conftest import Record


@pytest.fixture(scope="module")
def search(delta: DeltaRobot, record: Record) -> Search:
    wrong = EffectEntry(effect="home_offset", component="motor1", parameters={"angle": 0.02})
    model = DeltaModel(delta, [record(wrong, seconds=16.0)])
    return Search(prepare(model, model.readings.valid), 1e-3)


def _candidate(search: Search, effect: str) -> Candidate:
    return next(one for one in search.prepared.model.candidates if one.effect == effect)


@pytest.mark.parametrize("steps", [0.0, 0.99, -0.5])
def test_less_than_one_step_is_not_lost(steps: float) -> None:
    assert impossible(Term(lost_steps("motor1", 5.0), np.array([steps, 5.0])))
    assert not impossible(Term(lost_steps("motor1", 5.0), np.array([np.copysign(1.5, steps), 5.0])))


@pytest.mark.parametrize("effect", ["following_lag", "gear_backlash", "joint_friction"])
def test_a_size_of_nothing_or_at_its_bound_is_none(search: Search, effect: str) -> None:
    candidate = _candidate(search, effect)
    origin = np.array(candidate.shapes[0].origin)
    highest = candidate.coordinates[0].high
    inside, at_bound = origin.copy(), origin.copy()
    inside[0], at_bound[0] = 0.1 * highest, highest
    assert impossible(Term(candidate, origin))
    assert impossible(Term(candidate, at_bound))
    assert not impossible(Term(candidate, inside))


def test_a_second_size_at_its_bound_belongs_to_the_effect(search: Search) -> None:
    """A pure lag has no dead time, and a stiff shaft no compliance."""
    assert not impossible(Term(_candidate(search, "following_lag"), np.array([0.05, 0.0])))
    assert not impossible(Term(_candidate(search, "joint_friction"), np.array([0.01, 0.0, 0.0])))


def test_steps_are_lost_neither_at_the_beginning_nor_at_the_end(search: Search) -> None:
    """There they are an offset, or nothing: a home offset drew them to the first reading."""
    t_s = search.prepared.model.readings.t_s
    edge_s = ESTIMATION.edge * (t_s[-1] - t_s[0])
    at_s = t_s[0] + 1.5 * edge_s
    fitted = search.fitter.solve((Term(lost_steps("motor1", at_s), np.array([-50.0, at_s])),), ())
    moment_s = float(fitted.terms[0].candidate.values(fitted.terms[0].at)["time"])
    assert t_s[0] + edge_s < moment_s < at_s
    for number, jump in enumerate(search.tests._jumps(search.tests.empty)):
        assert t_s[0] + edge_s < jump.time_s < t_s[-1] - edge_s, number
    assert jumps(search.fitter, search.tests.empty, 1e-3, float(t_s[0]) - 10.0) == []


@pytest.mark.study
def test_the_rest_is_fitted_again_without_it(search: Search) -> None:
    home = Term(_candidate(search, "home_offset"), np.array([0.01]))
    half_a_step = Term(lost_steps("motor2", 7.0), np.array([0.4, 7.0]))
    solution = search.fitter.solve((half_a_step, home))
    stands = stands_of(search, solution)
    chances = credible(search, solution, stands)
    told = Explained(search, solution, 0.0, False, search.tests.empty, stands, chances)
    number = first_impossible(solution)
    assert number == 0
    left = less(told, number)
    assert [term.candidate.effect for term in left.solution.terms] == ["home_offset"]
    assert len(left.stands) == 1
    assert first_impossible(left.solution) is None
    assert left.solution.terms[0].at[0] == pytest.approx(0.02, abs=1e-3)


def test_arms_that_shrink_by_four_percent_are_something_else(
    search: Search, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only where the whole interval lies beyond what a plastic does: a wide one may pass it."""
    warming, model = _candidate(search, "thermal_expansion"), search.prepared.model
    fitter = copy(search.fitter)

    def fitted(strain: float) -> Solution:
        term = Term(warming, np.array([strain, np.log(6.0)]))
        noise = search.fitter.observed - search.tests.empty.predicted
        fitter.observed = model.predict([*(n.term for n in model.nuisances), term]) + noise
        return fitter.solve((term,), steps=2)

    assert beyond_physics(fitter, fitted(0.01)) is None
    shrunk = fitted(-0.046)
    assert beyond_physics(fitter, shrunk) == "thermal_expansion"
    left = lacking(model, "thermal_expansion").candidates
    assert {one.effect for one in model.candidates} - {one.effect for one in left} == {
        "thermal_expansion"
    }
    monkeypatch.setattr(intervals, "by_profile", lambda *_: {"strain": (-0.09, -0.001)})
    assert beyond_physics(fitter, shrunk) is None
