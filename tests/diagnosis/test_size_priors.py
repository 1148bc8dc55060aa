"""Priors of size and the evidence from a score, against integrals done by brute force."""

from __future__ import annotations

import pytest

from deltactl.diagnosis.plants.delta.candidates import candidates_of, late_readings
from deltactl.diagnosis.priors.size_priors import odds_cost
from deltactl.models.effects import VOCABULARY

DELTA = [n for n in VOCABULARY if candidates_of(n, 1.0, 60.0) or n == late_readings().effect]


def _candidate(effect: str):
    found = candidates_of(effect, travel_rad=1.0, span_s=120.0)
    return found[0] if found else late_readings()


@pytest.mark.parametrize("effect", DELTA)
def test_every_effect_of_a_delta_has_a_prior_of_its_own(effect):
    candidate = _candidate(effect)
    own = {p.name: p for p in candidate.kind.parameters}
    for i in candidate.moved:
        parameter = own[candidate.coordinates[i].parameter]
        assert parameter.typical or parameter.spread, f"{effect}: {parameter.name}"
    assert odds_cost(candidate) > 0.0
