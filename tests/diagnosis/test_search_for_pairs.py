"""Two causes that look like a third one first are found as the pair they are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.evidence.noise_estimation import prepare
from deltactl.diagnosis.plants.candidate import Candidate, Term
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.priors.penalties import Trial, penalty
from deltactl.diagnosis.score_tests.pair_scores import best_pairs, leading
from deltactl.diagnosis.search.addition import likely
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.ambiguity import equivalents_of
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]
TRUTH = {("gear_ratio", "motor1"), ("joint_compliance", "joints")}


@pytest.mark.study
def test_the_best_pair_is_the_truth_and_the_search_takes_it(
    delta: DeltaRobot, record: Record
) -> None:
    soft = EffectEntry(
        effect="joint_compliance", component="joints", parameters={"stiffness": 300.0}
    )
    ratio = EffectEntry(effect="gear_ratio", component="motor1", parameters={"scale": 0.985})
    model = DeltaModel(delta, [record(soft, ratio, seconds=40.0)])
    search = Search(prepare(model, model.readings.valid.copy()), 0.0)
    empty, scorer = search.tests.empty, search.prepared.scorer
    entries = leading(scorer, search.tests.scores(empty), set())
    first, *others = best_pairs(scorer, empty.free_basis, empty.residual, entries, penalty, 3)
    assert {start.candidate.key for start in first.starts} == TRUTH
    assert [pair.value for pair in others] == sorted((p.value for p in others), reverse=True)
    assert first.value >= others[0].value
    assert {term.candidate.key for term in search.run().terms} == TRUTH


@pytest.mark.study
def test_what_tolerances_cannot_explain_is_tried_though_others_promise_more(quiet: Search) -> None:
    candidates = quiet.prepared.model.candidates
    lengths = [c for c in candidates if c.effect in ("forearm_length", "upper_arm_length")]
    lengths += [c for c in candidates if c.effect == "home_offset"]
    friction = next(c for c in candidates if c.key == ("joint_friction", "motor2"))

    def trial(one: Candidate, gain: float, log_p: float) -> Trial:
        return Trial(Term(one, np.zeros(len(one.coordinates))), gain, log_p, penalty(one))

    promising = [trial(one, 150.0 - n, -10.0) for n, one in enumerate(lengths)]
    sure, faint = trial(friction, 80.0, -40.0), trial(friction, 50.0, -40.0)
    assert len(promising) > quiet.options.tried
    assert likely([*promising, sure], quiet.options) == [
        *promising[: quiet.options.tried],
        sure,
    ]
    assert faint not in likely([*promising, faint], quiet.options)
    first, *others = promising
    surest = trial(first.start.candidate, first.gain, -50.0)
    assert sure not in likely([surest, *others, sure], quiet.options)


@pytest.fixture(scope="module")
def quiet(delta: DeltaRobot, record: Record) -> Search:
    model = DeltaModel(delta, [record(seconds=15.0)])
    return Search(prepare(model, model.readings.valid.copy()), 0.0)


@pytest.mark.study
def test_what_is_taken_is_in_no_pair(quiet: Search) -> None:
    scorer, taken = quiet.prepared.scorer, {("base_radius", "frame")}
    entries = [
        scorer.library.entries[n] for n in leading(scorer, quiet.tests.scores_of_empty, taken)
    ]
    keys = [entry.key for entry in entries]
    assert len(keys) == len(set(keys)) > 20
    assert ("base_radius", "frame") not in keys
    assert ("forearm_length", "arm1") in keys
    assert not any(entry.candidate is None or entry.candidate.members for entry in entries)


def test_a_coordinate_at_the_end_of_its_range_cannot_give_way(quiet: Search) -> None:
    candidates = quiet.prepared.model.candidates
    friction = next(c for c in candidates if c.key == ("joint_friction", "motor1"))
    solution = quiet.fitter.solve([Term(friction, np.array([0.005, 0.0, 0.01]))], steps=0)
    assert solution.tangent.shape[1] - solution.free_tangent.shape[1] == 1


def test_play_that_hangs_on_one_flank_is_tried_as_a_home_offset(quiet: Search) -> None:
    candidates = quiet.prepared.model.candidates
    play = next(c for c in candidates if c.key == ("gear_backlash", "motor2"))
    hanging = Term(play, np.array([0.02, 1.0, 0.0]))
    found = equivalents_of([hanging], candidates)
    assert {term.candidate.key for term in found} == {("home_offset", "motor2")}
    assert sorted(float(term.at[0]) for term in found) == [-0.01, 0.01]


@pytest.mark.study
def test_one_that_stands_for_two_beside_a_third_gives_way(
    delta: DeltaRobot, record: Record
) -> None:
    causes = [
        EffectEntry(effect="joint_compliance", component="joints", parameters={"stiffness": 300.0}),
        EffectEntry(effect="gear_ratio", component="motor1", parameters={"scale": 0.985}),
        EffectEntry(effect="sensor_scale", component="range_x", parameters={"scale": 1.02}),
    ]
    model = DeltaModel(delta, [record(*causes, seconds=40.0)])
    search = Search(prepare(model, model.readings.valid.copy()), 0.0)
    starts = {
        trial.start.candidate.key: trial.start for trial in search.tests.trials(search.tests.empty)
    }
    names = [("frame_tilt", "frame"), ("sensor_scale", "range_x")]
    wrong = search.fitter.solve([starts[name] for name in names])
    found = {term.candidate.key for term in search.finished(wrong).terms}
    assert found == {("sensor_scale", "range_x"), *TRUTH}
