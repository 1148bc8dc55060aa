"""Noise that was taken with the mismatch in it is taken again once the mismatch is known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from deltactl.diagnosis.evidence.noise_estimation import prepare
from deltactl.diagnosis.plants.delta.model import DeltaModel
from deltactl.diagnosis.search.search import Search
from deltactl.diagnosis.selection.model_choice import calmed
from deltactl.models.robot import DeltaRobot, EffectEntry
from deltactl.recording.tables.flat import FlatRecording

Record = Callable[..., FlatRecording]


@pytest.mark.study
def test_ringing_does_not_pass_for_noise_with_a_memory(delta: DeltaRobot, record: Record) -> None:
    ringing = EffectEntry(
        effect="resonance", component="platform", parameters={"frequency": 2.35, "damping": 0.05}
    )
    model = DeltaModel(delta, [record(ringing, seconds=40.0, rho=0.0)])
    first = Search(prepare(model, model.readings.valid.copy()), 0.0)
    last, solution = calmed(first, first.run())
    assert [term.candidate.effect for term in solution.terms] == ["resonance"]
    frequency, damping = solution.terms[0].at
    assert abs(np.exp(frequency) - 2.35) < 0.03
    assert abs(damping - 0.05) < 0.01
    before, after = (search.fitter.whiten.channels for search in (first, last))
    assert all(a.sigma > b.sigma for a, b in zip(before, after, strict=True))
    assert max(abs(noise.phi).max() for noise in after) < 0.1
