"""The Cramer-Rao bound against cases that can be worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the proof's robot needs the extra 'proof' (MuJoCo)")

from deltactl.proof.cases import assemble
from deltactl.proof.prove.one_case import as_recorded, bound, distance
from deltactl.proof.ranging import Noise
from deltactl.proof.recorded import record_with_truth, sample_times

NOISE = Noise(0.002, 0.6, outliers=0.01, dropouts=0.03)


def case_of(effect, noise=NOISE, seconds=3.0):
    case = assemble(0, "single", [effect], np.random.default_rng(3), "survey", seconds)
    case.machine = replace(case.machine, noise=noise)
    return case


@pytest.mark.parametrize("rho", [0.0, 0.6])
def test_an_offset_is_known_as_well_as_a_mean_of_correlated_noise(rho):
    case = case_of("sensor_offset", replace(NOISE, rho=rho))
    samples = len(sample_times(case.train)) - 1
    variance = (0.002**2 + 1e-6 / 12.0) * (1.0 + rho) / (1.0 - rho)
    expected = np.sqrt(variance / (0.96 * samples))
    assert bound(case)["offset"] == pytest.approx([expected], rel=1e-6)


def test_sizes_that_are_free_together_are_known_less_well():
    case = case_of("sensor_drift")
    both = bound(case)
    slope = case.planned[0].parameters
    t_s = sample_times(case.train)
    share = -np.expm1(-t_s / slope["time_constant"])
    white = (share[1:] - 0.6 * share[:-1]) / np.sqrt((4e-6 + 1e-6 / 12.0) * 0.64)
    alone = 1.0 / np.sqrt(0.96 * white @ white)
    assert set(both) == {"offset", "time_constant"}
    assert both["offset"][0] > 3.0 * alone


def test_a_vector_has_one_bound_each_and_an_event_none():
    assert len(bound(case_of("frame_tilt"))["rotation"]) == 3
    assert bound(case_of("lost_steps")) is None
    assert bound(case_of("stripes")) is None


def test_the_distance_of_an_offset_is_its_size_over_its_bound():
    case = case_of("sensor_offset")
    size = abs(case.planned[0].parameters["offset"])
    assert distance(case) == pytest.approx(size / bound(case)["offset"][0], rel=1e-6)


def test_the_recorded_run_saves_one_run_of_the_bound_and_changes_nothing():
    case = case_of("home_offset")
    _, truth = record_with_truth(case.machine, case.train, np.random.default_rng(1))
    still = as_recorded(case, truth)
    assert bound(case, still)["angle"] == pytest.approx(bound(case)["angle"], rel=1e-9)
    assert distance(case, still) == pytest.approx(distance(case), rel=1e-9)
    loose = case_of("gear_backlash")
    assert as_recorded(loose, truth) is None
