"""Noise, outliers, dropouts and rounding of the second robot's sensors, and its step counts."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("mujoco", reason="the proof's robot needs the extra 'proof' (MuJoCo)")

from deltactl.proof.motions import HIGHEST, LOWEST, SHAPES, curve, survey
from deltactl.proof.ranging import Noise, Sensors, dropouts, ideal_ranges, read, wander
from deltactl.proof.recorded import sample_times
from deltactl.proof.robot.as_built import Body, Joints, StepTrain, three, together
from deltactl.proof.robot.bodies import Assembly, build
from deltactl.proof.robot.run import Truth

COUNT = st.integers(0, 400)
TARGETS = st.lists(st.tuples(COUNT, COUNT, COUNT), min_size=1, max_size=5)


def still(seconds: float) -> Truth:
    t_s = np.arange(0.0, seconds, 0.005)
    return Truth(t_s, np.tile([0.01, 0.02, -0.45], (len(t_s), 1)), np.zeros((len(t_s), 3)), 0.0)


@pytest.mark.parametrize("rho", [0.0, 0.6])
def test_noise_has_its_size_and_correlation(rho):
    noise = wander(Noise(0.002, rho), 40_000, np.random.default_rng(0))
    assert noise.std(axis=0) == pytest.approx([0.002] * 3, rel=0.03)
    neighbours = np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]
    assert neighbours == pytest.approx(rho, abs=0.02)


def test_readings_are_whole_millimetres_with_outliers_and_dropouts():
    t_s = np.arange(0.04, 199.9, 0.02)
    noise = Noise(0.0, 0.0, outliers=0.02, dropouts=0.03)
    ranges, status = read(Sensors(), noise, still(200.0), t_s, np.random.default_rng(1))
    assert np.allclose(ranges * 1000, np.round(ranges * 1000), atol=1e-9)
    assert (status != 0).mean() == pytest.approx(0.03, abs=0.005)
    assert set(np.unique(status)) == {0, 1, 2, 7}
    wrong = np.abs(ranges - [0.61, 0.62, 0.45]) > 0.015
    assert wrong[status == 0].mean() == pytest.approx(0.02, abs=0.004)


def test_averaging_over_the_exposure_makes_nothing_late():
    truth = still(10.0)
    moving = truth.position_m + np.outer(truth.t_s, [0.01, 0.0, 0.0])
    t_s = np.arange(0.1, 9.8, 0.02)
    ranges = ideal_ranges(Sensors(), Truth(truth.t_s, moving, truth.arm_rad, 0.0), t_s)
    assert ranges[:, 0] == pytest.approx(0.61 + 0.01 * t_s, abs=1e-12)


def test_a_slow_sensor_is_late_by_its_time_constant():
    truth = still(10.0)
    moving = truth.position_m + np.outer(truth.t_s, [0.0, 0.01, 0.0])
    t_s = np.array([8.0])
    slow = Sensors(own_lag_s=np.array([0.0, 0.2, 0.0]))
    ranges = ideal_ranges(slow, Truth(truth.t_s, moving, truth.arm_rad, 0.0), t_s)
    assert ranges[0, 1] == pytest.approx(0.62 + 0.01 * (8.0 - 0.2), abs=5e-5)


@settings(max_examples=25, deadline=None)
@given(TARGETS, TARGETS)
def test_motors_step_together_by_single_steps_and_arrive(targets, more):
    goals = np.array([*targets, *more])
    train = together(np.array([200, 200, 200]), goals, np.zeros(len(goals)), 0.002)
    assert np.abs(np.diff(train.counts, axis=0)).max(initial=0) <= 1
    assert tuple(train.counts[-1]) == tuple(goals[-1])
    longest = np.abs(np.diff(np.vstack([[200, 200, 200], goals]), axis=0)).max(axis=1).sum()
    assert len(train.counts) == 1 + longest


def test_the_smooth_count_is_neither_ahead_nor_late():
    train = StepTrain(0.002, np.repeat(np.arange(500)[:, None], 3, axis=1))
    t_s = sample_times(train)
    assert (train.at(t_s) - train.smooth(t_s)).mean() == pytest.approx(0.0, abs=1e-9)


def test_surveys_keep_to_angles_that_can_be_assembled():
    train = survey(np.random.default_rng(3), 60.0, 0.002)
    assert train.seconds == pytest.approx(60.0)
    assert train.counts.min() >= LOWEST
    assert train.counts.max() <= HIGHEST


@pytest.mark.parametrize("shape", sorted(SHAPES))
def test_curves_close_and_both_ways_differ(shape):
    way = curve(shape, 0.08, -0.45, 90.0, 0.002)
    back = curve(shape, 0.08, -0.45, 90.0, 0.002, clockwise=True)
    assert np.abs(np.diff(way.counts, axis=0)).max() <= 1
    assert way.seconds == pytest.approx(90.0)
    assert not np.array_equal(way.counts, back.counts) or shape == "spiral"


def test_invalid_readings_come_in_rows_of_the_length_asked_for():
    asked = Noise(0.002, dropouts=0.03, dropout_samples=20.0)
    _, status = dropouts(asked, np.zeros((60_000, 3)), np.random.default_rng(5))
    lost = status != 0
    begins = np.count_nonzero(lost[1:] & ~lost[:-1])
    assert lost.mean() == pytest.approx(0.03, rel=0.15)
    assert np.count_nonzero(lost) / begins == pytest.approx(20.0, rel=0.15)


def test_a_robot_6_mm_too_wide_can_be_assembled_wherever_a_survey_takes_it():
    body = Body(base_radius_m=three(0.325 + 0.006))
    robot = Assembly(build(body, Joints(), 0.001))
    highest = max(
        float(robot.platform_m(np.radians(np.array(counts) * 0.0225))[2])
        for counts in product((LOWEST, HIGHEST), repeat=3)
    )
    elbow_m = -0.25 * np.sin(np.radians(LOWEST * 0.0225))
    assert highest < elbow_m - 0.04, "the platform must hang below the elbows"
