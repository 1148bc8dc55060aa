"""Columns of spline terms are not kept, and come out as if they were."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.evidence.noise_estimation import Prepared, prepare
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.models.robot import DeltaRobot
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]


@pytest.fixture(scope="module")
def prepared(delta: DeltaRobot, record: Record) -> Prepared:
    model = DeltaModel(delta, [record(seconds=20.0)])
    return prepare(model, model.readings.valid.copy())


@pytest.mark.study
def test_whitened_columns_are_those_of_the_raw_ones(prepared: Prepared) -> None:
    library = prepared.library
    dense = prepared.fitter.whiten.each(library.raw()).T
    scale = np.abs(dense).max(axis=0)
    assert dense.shape == library.white.shape
    np.testing.assert_allclose(library.white / scale, dense / scale, atol=2e-5)
    assert sum(entry.free is not None for entry in library.entries) > 20


@pytest.mark.parametrize("draws", [(), (3,)])
def test_what_all_explain_together_is_the_sum_over_the_columns(
    prepared: Prepared, draws: tuple[int, ...]
) -> None:
    raw = prepared.library.raw().astype(np.float64)
    size = np.sqrt(np.mean(raw**2, axis=(1, 2)))
    drawn = np.random.default_rng(2).standard_normal((len(raw), *draws))
    weights = drawn / size.reshape(-1, *(1 for _ in draws))
    whole = np.swapaxes(np.tensordot(raw, weights, axes=(0, 0)), 0, 1)
    np.testing.assert_allclose(prepared.library.explained(weights), whole, atol=1e-4)
