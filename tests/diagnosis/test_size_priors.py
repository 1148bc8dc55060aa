"""Priors of size and the evidence from a score, against integrals done by brute force."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, trapezoid

from deltactl.diagnosis.plants.delta.candidates import candidates_of, late_readings
from deltactl.diagnosis.priors.options import SIZE_PRIORS
from deltactl.diagnosis.priors.size_priors import odds_cost, prior_of, score_log_odds
from deltactl.models.effects import VOCABULARY

DELTA = [n for n in VOCABULARY if candidates_of(n, 1.0, 60.0) or n == late_readings().effect]


def _candidate(effect: str):
    found = candidates_of(effect, travel_rad=1.0, span_s=120.0)
    return found[0] if found else late_readings()


@pytest.mark.parametrize("effect", ["home_offset", "gear_backlash", "sensor_latency", "payload"])
def test_the_density_of_a_size_adds_up_to_one(effect):
    prior = prior_of(_candidate(effect))
    sides = 1.0 if prior.one_sided[0] else 2.0
    lengths = prior.typical * np.exp(np.linspace(-8.0, 8.0, 4001))
    density = np.exp([prior.log_density(float(one)) for one in lengths])
    assert sides * trapezoid(density, lengths) == pytest.approx(1.0, abs=1e-3)


def test_a_size_of_two_numbers_adds_up_over_the_plane():
    prior = prior_of(_candidate("transmission_error"))
    lengths = prior.typical * np.exp(np.linspace(-8.0, 8.0, 4001))
    density = np.exp([prior.log_density(float(one)) for one in lengths])
    ring = 2.0 * math.pi * lengths
    assert trapezoid(density * ring, lengths) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("effect", DELTA)
def test_every_effect_of_a_delta_has_a_prior_of_its_own(effect):
    candidate = _candidate(effect)
    own = {p.name: p for p in candidate.kind.parameters}
    for i in candidate.moved:
        parameter = own[candidate.coordinates[i].parameter]
        assert parameter.typical or parameter.spread, f"{effect}: {parameter.name}"
    assert odds_cost(candidate) > 0.0


@given(found=st.floats(-0.05, 0.05), spread=st.floats(1e-4, 5e-3))
def test_the_odds_from_a_score_are_the_integral_over_sizes(found, spread):
    candidate = _candidate("home_offset")
    prior = prior_of(candidate)

    def integrand(log_size: float) -> float:
        size = math.exp(log_size)
        weight = math.exp(prior.log_density(size)) * size  # per log size
        return weight * sum(math.exp(-0.5 * ((found - s) / spread) ** 2) for s in (size, -size))

    low = max(math.log(SIZE_PRIORS.shows * spread), math.log(prior.typical) - 4.0 * math.log(3.0))
    high = math.log(prior.typical) + 4.0 * math.log(3.0)
    peak = math.log(min(max(abs(found), math.exp(low)), math.exp(high)))
    whole = quad(integrand, low, high, points=[peak], limit=400)[0]
    expected = math.log(max(whole, 1e-300)) + 0.5 * (found / spread) ** 2
    expected -= 0.5 * odds_cost(candidate)
    got = score_log_odds(candidate, (0,), np.array([found]), np.array([[spread**-2]]))
    if whole > 1e-250:
        assert got == pytest.approx(expected, abs=0.05)


def test_a_size_that_would_not_show_says_nothing():
    blind = np.array([[1e-6]])
    assert score_log_odds(_candidate("home_offset"), (0,), np.array([0.1]), blind) == -math.inf


@given(gain=st.floats(10.0, 200.0))
def test_more_of_a_score_is_more_probable(gain):
    candidate, information = _candidate("home_offset"), np.array([[1e6]])
    odds = [
        score_log_odds(candidate, (0,), np.array([math.sqrt(g) * 1e-3]), information)
        for g in (gain, 1.2 * gain)
    ]
    assert odds[1] > odds[0]
