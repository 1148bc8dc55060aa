"""Intervals have room for what no robot file can promise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from deltactl.diagnosis.assessment.intervals import covariance
from deltactl.diagnosis.estimation.estimate import Solution
from deltactl.diagnosis.estimation.least_squares import Fitter
from deltactl.diagnosis.estimation.noise import estimate
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.priors.options import PENALTIES
from deltactl.diagnosis.priors.tolerances import giving_way, pull
from deltactl.models.effects import card_of
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]


def _fitted(
    delta: DeltaRobot, recording: FlatRecording, key: tuple[str, str], at: list[float]
) -> tuple[Fitter, Solution]:
    model = DeltaModel(delta, [recording])
    term = Term(next(c for c in model.candidates if c.key == key), np.array(at))
    left = model.readings.values - model.predict([*(n.term for n in model.nuisances), term])
    fitter = Fitter(
        model,
        estimate(model.readings, model.readings.valid, np.nan_to_num(left)),
        model.nuisances,
    )
    return fitter, fitter.solve([term])


def _bread(solution: Solution) -> np.ndarray:
    return np.linalg.pinv(solution.tangent.T @ solution.tangent, hermitian=True)


def test_an_offset_is_no_surer_than_the_sensor_is_mounted(
    delta: DeltaRobot, record: Record
) -> None:
    off = EffectEntry(effect="sensor_offset", component="range_z", parameters={"offset": 0.005})
    fitter, solution = _fitted(
        delta, record(off, seconds=30.0), ("sensor_offset", "range_z"), [0.005]
    )
    place = solution.columns_of(0).start
    pulled = pull(fitter, solution, _bread(solution))[place]
    mounted = PENALTIES.most_careful * (card_of("sensor_offset").build_spread or 0.0)
    assert np.isclose(np.abs(pulled), mounted, rtol=1e-6).any()
    plain = _bread(solution)[place, place]
    assert covariance(fitter, solution)[place, place] >= plain + pulled @ pulled


def test_errors_that_are_fitted_with_room_pull_nothing(delta: DeltaRobot, record: Record) -> None:
    off = EffectEntry(effect="sensor_offset", component="range_z", parameters={"offset": 0.005})
    fitter, solution = _fitted(
        delta, record(off, seconds=20.0), ("sensor_offset", "range_z"), [0.005]
    )
    model = fitter.model
    loose = Fitter(model, fitter.whiten, [*model.nuisances, *model.tolerances])
    fitted = loose.solve(solution.terms)
    assert not pull(loose, fitted, _bread(fitted)).any()


def test_an_interval_has_room_for_what_a_stop_gives_way(delta: DeltaRobot, record: Record) -> None:
    stop = EffectEntry(effect="contact", component="platform", parameters={"height": -0.44})
    fitter, solution = _fitted(
        delta, record(stop, seconds=5.0), ("contact", "platform"), [-0.44, 0.0]
    )
    candidate = solution.terms[0].candidate
    rigid = replace(candidate.kind.discrepancy, gives_way={})
    kind = replace(candidate.kind, discrepancy=rigid)
    stiff = Term(replace(candidate, kind=kind), solution.terms[0].at)
    room = covariance(fitter, solution) - covariance(fitter, replace(solution, terms=(stiff,)))
    expected = np.diag(giving_way(solution))
    assert expected.max() == 2.5e-4**2
    assert room == pytest.approx(expected, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize(
    ("key", "at", "expected"),
    [
        (("contact", "platform"), [-0.5, 1.0], [2.5e-4**2, 0.0]),
        (("base_radius", "frame"), [0.001], [0.0]),
    ],
)
def test_only_a_stop_gives_way(
    delta: DeltaRobot, record: Record, key: tuple[str, str], at: list[float], expected: list[float]
) -> None:
    model = DeltaModel(delta, [record(seconds=5.0)])
    term = Term(next(c for c in model.candidates if c.key == key), np.array(at))
    tangent = np.zeros((3, 1 + len(at)))
    late = model.nuisances[0].term
    solution = Solution(
        (term,), (late,), (), np.zeros(0), 0.0, np.zeros(3), np.zeros((1, 3)), lambda: tangent
    )
    assert giving_way(solution).tolist() == [0.0, *expected]
