"""Intervals in the units of a parameter, whatever the fit moves in: logarithm, reciprocal, wave."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.diagnosis.answer.records import ParameterResult
from deltactl.diagnosis.assessment.intervals import NORMAL_95, parameters, spreads
from deltactl.diagnosis.plants.candidate import Term
from deltactl.diagnosis.plants.delta.candidates import candidates_of

SPREADS = st.floats(1e-3, 0.5)
FEW = settings(max_examples=15)


def sizes(effect: str, at: list[float], spread: list[float]) -> dict[str, ParameterResult]:
    """What the answer says of an effect that the fit left `at`, so well known."""
    candidate = candidates_of(effect, travel_rad=2.0, span_s=60.0)[0]
    return parameters(Term(candidate, np.array(at)), np.diag(np.square(spread)))


@FEW
@given(SPREADS)
def test_what_is_fitted_as_a_logarithm_is_known_to_a_factor(spread: float) -> None:
    """A warming of 60 s known to a factor of two lasts 30 to 120 s, not 0 to 120."""
    found = sizes("thermal_expansion", [0.001, math.log(60.0)], [1e-4, spread])
    low, high = found["time_constant"].ci95
    factor = math.exp(NORMAL_95 * spread)
    assert low == pytest.approx(60.0 / factor)
    assert high == pytest.approx(60.0 * factor)
    assert list(found["strain"].ci95) == pytest.approx(
        [0.001 - 1e-4 * NORMAL_95, 0.001 + 1e-4 * NORMAL_95]
    )


@FEW
@given(SPREADS)
def test_a_stiffness_has_the_ends_of_what_gives_way(spread: float) -> None:
    """Fitted as a compliance; what may as well be nothing leaves the stiffness without an end."""
    soft = 1e-3
    (found,) = sizes("joint_compliance", [soft], [soft * spread]).values()
    low, high = found.ci95
    assert found.value == pytest.approx(1.0 / soft)
    assert low == pytest.approx(1.0 / (soft * (1.0 + NORMAL_95 * spread)))
    assert high == pytest.approx(1.0 / (soft * (1.0 - NORMAL_95 * spread)))
    (vague,) = sizes("joint_compliance", [soft], [2.0 * soft]).values()
    assert vague.ci95 == [pytest.approx(1.0 / (soft * (1.0 + 2.0 * NORMAL_95))), None]


def test_a_shaft_that_does_not_yield_has_no_stiffness_to_state() -> None:
    assert sizes("joint_compliance", [0.0], [0.0]) == {}


def test_a_size_that_cannot_be_negative_ends_at_nothing() -> None:
    """Its other end stays where it is."""
    found = sizes("following_lag", [0.02, 0.0], [0.02, 0.01])["time"]
    assert found.ci95 == [0.0, pytest.approx(0.02 * (1.0 + NORMAL_95))]


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_beyond_what_the_fit_was_let_an_interval_has_no_end(side: float) -> None:
    low, high = sizes("home_offset", [side * 0.59], [0.1])["angle"].ci95
    assert (low is None, high is None) == (side < 0.0, side > 0.0)
    inner = high if low is None else low
    assert inner == pytest.approx(side * (0.59 - 0.1 * NORMAL_95))


def test_each_number_of_a_vector_has_its_own_ends() -> None:
    found = sizes("frame_tilt", [0.01, 0.02, 0.03], [1e-3, 2e-3, 3e-3])["rotation"]
    assert np.mean(found.ci95, axis=1) == pytest.approx([0.01, 0.02, 0.03])
    assert np.ptp(found.ci95, axis=1) == pytest.approx(2e-3 * NORMAL_95 * np.array([1, 2, 3]))


@FEW
@given(st.floats(0.0, 2.0 * math.pi), st.floats(1e-6, 1e-4))
def test_a_wave_is_as_well_known_whatever_its_phase(phase: float, spread: float) -> None:
    """Sine and cosine are: the amplitude by as much, the phase by that over the amplitude."""
    sine, cosine = 2e-3 * math.cos(phase), 2e-3 * math.sin(phase)
    found = sizes("transmission_error", [sine, cosine, 0.0], [spread, spread, 1e-3])
    for name, value, half in (
        ("amplitude", 2e-3, NORMAL_95 * spread),
        ("phase", math.remainder(phase, math.tau), NORMAL_95 * spread / 2e-3),
    ):
        assert math.remainder(found[name].value - value, math.tau) == pytest.approx(0.0, abs=1e-9)
        low, high = found[name].ci95
        assert (high - low) / 2.0 == pytest.approx(half)
        assert (high + low) / 2.0 == pytest.approx(found[name].value)


def test_sizes_that_make_up_for_each_other_spread_together() -> None:
    """Dead time and time constant share a lag: their sum is known, what each has of it is not."""
    candidate = candidates_of("following_lag", travel_rad=2.0, span_s=60.0)[0]
    factor = np.array([[8e-3, 0.0], [-8e-3, 1e-3]])
    lag = spreads(Term(candidate, np.array([0.07, 0.06])), factor @ factor.T)
    rows = np.zeros((2, 2))
    for row, found in zip(rows, (lag["time"], lag["dead_time"]), strict=True):
        row[: len(found)] = found
    np.testing.assert_allclose(rows @ rows.T, factor @ factor.T, rtol=0.02, atol=1e-9)
    assert np.linalg.norm(rows[0] + rows[1]) == pytest.approx(1e-3, rel=0.1)


@pytest.mark.parametrize(("name", "at"), [("frame_tilt", [0.0] * 3), ("joint_compliance", [0.0])])
def test_what_has_no_size_of_one_number_has_no_spread(name: str, at: list[float]) -> None:
    """A vector alone, or a shaft that does not yield."""
    term = Term(candidates_of(name, travel_rad=2.0, span_s=60.0)[0], np.array(at))
    assert spreads(term, np.eye(len(at))) == {}
