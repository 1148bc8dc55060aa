"""Steps of a fit beside spline terms, and what a solution can do without."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.diagnosis.estimation.change_point_timing import shown_later
from deltactl.diagnosis.estimation.estimate import Solution, orthonormal
from deltactl.diagnosis.estimation.levenberg_marquardt import Slopes
from deltactl.diagnosis.estimation.options import ESTIMATION
from deltactl.diagnosis.evidence.noise_estimation import prepare
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.candidates import lost_steps
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.search import removal
from deltactl.diagnosis.search.removal import (
    begun_without,
    clearly_needed,
    drop,
    each_left_out,
    spare,
)
from deltactl.diagnosis.search.search import Search
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]


@pytest.fixture(scope="module")
def search(delta: DeltaRobot, record: Record) -> Search:
    scale = EffectEntry(effect="sensor_scale", component="range_x", parameters={"scale": 1.02})
    lost = EffectEntry(
        effect="lost_steps", component="motor2", parameters={"steps": -40.0, "time": 12.0}
    )
    model = DeltaModel(delta, [record(scale, lost, seconds=30.0)])
    assert delta.drive is not None
    return Search(prepare(model, model.readings.valid.copy()), delta.drive.rad_per_step)


@pytest.fixture(scope="module")
def found(search: Search) -> Solution:
    solution = search.run()
    keys = {term.candidate.key for term in solution.terms}
    assert keys == {("sensor_scale", "range_x"), ("lost_steps", "motor2")}
    return solution


@given(st.integers(0, 2**31), st.integers(1, 5), st.integers(0, 4))
def test_a_step_beside_spline_terms_is_that_of_both_together(seed: int, p: int, q: int) -> None:
    rng = np.random.default_rng(seed)
    tangent, linear = rng.standard_normal((60, p)), rng.standard_normal((60, q))
    residual, basis = rng.standard_normal(60), orthonormal(linear)
    both = np.linalg.lstsq(np.concatenate([tangent, linear], axis=1), residual, rcond=None)[0]
    slopes, taken = Slopes(tangent, basis), basis.T @ residual
    step, promised = slopes.bounded_step(_free_terms(p), residual, taken, 0.0)
    np.testing.assert_allclose(step, both[:p], rtol=1e-6, atol=1e-9)
    left = residual - tangent @ step
    gain = float(residual @ residual - taken @ taken - left @ left + np.sum((basis.T @ left) ** 2))
    assert promised == pytest.approx(gain, rel=1e-6)


def _free_terms(count: int) -> list[Term]:
    """Terms of one coordinate each, without bounds."""
    one = lost_steps("motor1", 0.0)
    coordinate = next(c for c in one.coordinates if c.how != "frozen")
    free = Candidate(one.kind, "motor1", (coordinate,), (), {})
    return [Term(free, np.zeros(1)) for _ in range(count)]


@pytest.mark.study
def test_what_is_clearly_needed_is_needed(search: Search, found: Solution) -> None:
    for number, term in enumerate(found.terms):
        begun = begun_without(search, found, number)
        assert clearly_needed(search, found, number, begun)
        rest = search.fitter.solve(begun.terms, (), begun.nuisances)
        assert search.criterion.earns(rest, found, term.candidate)


@pytest.fixture(scope="module")
def more(search: Search, found: Solution) -> Solution:
    """The same with an effect that does nothing."""
    candidates = search.prepared.model.candidates
    idle = next(c for c in candidates if c.key == ("home_offset", "motor3"))
    return search.fitter.solve((*found.terms, Term(idle, np.zeros(len(idle.coordinates)))))


@pytest.mark.study
def test_what_does_nothing_is_dropped(search: Search, found: Solution, more: Solution) -> None:
    assert not clearly_needed(search, more, 2, begun_without(search, more, 2))
    kept = {term.candidate.key for term in drop(search, more).terms}
    assert kept == {term.candidate.key for term in found.terms}


def test_the_rest_is_remembered_without_what_makes_it_large(
    search: Search, found: Solution
) -> None:
    first = each_left_out(search, found)
    assert each_left_out(search, found) is first
    assert all("tangent" not in vars(one.fit) for one in first)


def test_a_moment_that_fits_better_is_found_from_far_off(search: Search, found: Solution) -> None:
    number = next(k for k, term in enumerate(found.terms) if term.candidate.kind.event)
    far = shown_later(
        found.terms[number], ESTIMATION.moments[-1] * 0.9 * search.fitter.model.readings.period_s
    )
    assert far is not None
    terms = (*found.terms[:number], far, *found.terms[number + 1 :])
    again = search.fitter.solve(terms, (), found.nuisances)
    assert again.cost == pytest.approx(found.cost, abs=1.0)


def test_what_is_dropped_again_leads_back_to_where_it_began(
    search: Search, found: Solution, more: Solution
) -> None:
    assert drop(search, more, before=found) is found


def test_what_is_surely_needed_is_not_asked_again(
    search: Search, found: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []

    def watched(search: Search, solution: Solution, number: int) -> Any:
        asked.append(number)
        return spare(search, solution, number)

    monkeypatch.setattr(removal, "spare", watched)
    fresh = Search(search.prepared, search.rad_per_step, known=search.tests.calibration)
    keys = [term.candidate.key for term in found.terms]
    assert drop(fresh, found, sure=frozenset(keys[:1])) is found
    assert asked == [1]
