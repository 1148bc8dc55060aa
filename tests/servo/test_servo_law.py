"""The control law against what theory says of it (Uzunovic 2013, equations 5 and 6)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from deltactl.firmware_py.servo.law import AccelerationControl, JointLaw, LawSettings

SLOW, FAST = -11.2701665, -88.7298335
"""Roots of s^2 + 100 s + 1000."""


def test_the_paper_s_gains_are_two_real_poles() -> None:
    assert np.sort(np.roots([1.0, 100.0, 1000.0])) == pytest.approx([FAST, SLOW])


def test_an_error_dies_as_the_two_poles_say_without_overshoot(joint, fine) -> None:
    start = 0.5
    angle, _, _ = joint(fine, start_rad=start).run(1.0, lambda t: 0.0)
    t_s = np.arange(len(angle)) * fine.period_s
    analytic = start * (FAST * np.exp(SLOW * t_s) - SLOW * np.exp(FAST * t_s)) / (FAST - SLOW)
    assert np.abs(angle - analytic).max() < 0.01 * start
    assert angle.min() > -1e-3 * start
    assert abs(angle[-1]) < 1e-4 * start


def test_the_reference_s_derivatives_are_equation_6(fine) -> None:
    """Feed-forward alone: no gains, no observer; a sine's second derivative through two filters."""
    bare = replace(fine, velocity_gain_1ps=0.0, position_gain_1ps2=0.0, disturbance_observer=False)
    law, omega, size = JointLaw(bare), 2 * np.pi * 30.0, 0.2
    law.reset(0.0, 0)
    t_s = np.arange(3000) * bare.period_s
    current = np.array([law.tick(size * np.sin(omega * t), 0) for t in t_s])
    acceleration = current / bare.amperes_per_radps2 / bare.gear_ratio
    share = bare.share(bare.reference_bandwidth_radps)
    back = np.exp(-1j * omega * bare.period_s)
    slope = share / bare.period_s * (1 - back) / (1 - (1 - share) * back)
    expected = size * np.imag(slope**2 * np.exp(1j * omega * t_s))
    settled = t_s > 0.1
    assert np.abs(acceleration - expected)[settled].max() < 1e-6 * np.abs(expected).max()
    g = bare.reference_bandwidth_radps
    continuous = g * 1j * omega / (1j * omega + g)
    assert abs(slope - continuous) < 0.02 * abs(continuous)


def test_a_steady_speed_is_followed_without_error(joint, fine) -> None:
    speed = 20.0
    angle, _, _ = joint(fine).run(1.5, lambda t: speed * t)
    t_s = np.arange(len(angle)) * fine.period_s
    assert abs(angle[-1] - speed * t_s[-1]) < 1e-6 * speed


def test_the_observer_s_estimate_comes_as_its_low_pass(joint, fine) -> None:
    """With a velocity observer far faster, the estimate of a step is 1 - exp(-g t)."""
    g, size = 300.0, 0.05
    slow = replace(fine, disturbance_bandwidth_radps=g, velocity_bandwidth_radps=7000.0)
    _, _, estimate = joint(slow, disturbance_a=lambda t: size).run(0.1, lambda t: 0.0)
    t_s = np.arange(len(estimate)) * fine.period_s
    assert np.abs(estimate - size * (1 - np.exp(-g * t_s))).max() < 0.06 * size
    assert estimate[-1] == pytest.approx(size, rel=1e-3)


def test_the_shipped_observers_converge_within_two_milliseconds(joint, fine) -> None:
    _, _, estimate = joint(fine, disturbance_a=lambda t: 0.05).run(0.2, lambda t: 0.0)
    late = np.arange(len(estimate)) * fine.period_s > 0.004
    assert np.abs(estimate[late] - 0.05).max() < 0.2 * 0.05
    assert estimate[-1] == pytest.approx(0.05, rel=1e-3)


@given(
    size=st.floats(-0.2, 0.2),
    inertia=st.floats(0.6, 3.0),
    torque_constant=st.floats(0.7, 1.4),
)
@settings(max_examples=15, deadline=None)
def test_at_rest_the_estimate_is_true_whatever_inertia_and_gain_are(
    joint, fine, drive, size, inertia, torque_constant
) -> None:
    """At rest current and disturbance balance: the estimate needs no model for that."""
    made = joint(
        fine,
        inertia_kgm2=inertia * drive.nominal_inertia_kgm2,
        torque_constant_nmpa=torque_constant * drive.torque_constant_nmpa,
        disturbance_a=lambda t: size,
    )
    angle, _, estimate = made.run(1.0, lambda t: 0.0)
    assert estimate[-1] == pytest.approx(size, abs=1e-5)
    assert abs(angle[-1]) < 1e-4


def test_without_the_observer_a_load_leaves_the_error_of_the_position_gain(joint, fine) -> None:
    size = 0.05
    bare = replace(fine, disturbance_observer=False)
    angle, _, _ = joint(bare, disturbance_a=lambda t: size).run(1.0, lambda t: 0.0)
    expected = -size / bare.amperes_per_radps2 / bare.position_gain_1ps2
    assert angle[-1] == pytest.approx(expected, rel=1e-3)
    with_it, _, _ = joint(fine, disturbance_a=lambda t: size).run(1.0, lambda t: 0.0)
    assert abs(with_it[-1]) < 1e-3 * abs(expected)


def test_saturation_is_a_limit_and_leaves_nothing_behind(joint, fine) -> None:
    """The observer sees the current that flowed, so in a long saturation nothing winds up.

    Where the current jumps from limit to limit the speed is seen a moment late: a twentieth.
    """
    tight = replace(fine, current_limit_a=0.05)
    made = joint(tight, start_rad=20.0, disturbance_a=lambda t: 0.01)
    angle, current, estimate = made.run(2.0, lambda t: 0.0)
    assert np.abs(current).max() == 0.05
    assert (np.abs(current) == 0.05).sum() > 100
    late = np.arange(len(estimate)) > 50
    assert np.abs(estimate[late] - 0.01).max() < 0.05 * (2 * 0.05)
    assert angle.min() > -0.05 * 20.0
    assert abs(angle[-1]) < 1e-3


def test_encoder_counts_leave_an_error_of_about_a_count(joint, drive) -> None:
    coarse = LawSettings.of(drive)
    count_rad = coarse.gear_ratio * coarse.rad_per_count
    made = joint(coarse, start_rad=50 * count_rad, disturbance_a=lambda t: 0.03)
    angle, current, _ = made.run(2.0, lambda t: 0.0)
    assert np.abs(angle[-5000:]).max() < 1.5 * count_rad
    assert np.abs(current).max() < coarse.current_limit_a  # quantisation alone never saturates


def test_a_slow_ramp_is_followed_through_the_counts(joint, drive) -> None:
    coarse = LawSettings.of(drive)
    count_rad = coarse.gear_ratio * coarse.rad_per_count
    angle, _, _ = joint(coarse).run(1.5, lambda t: 30 * count_rad * t)
    reference = 30 * count_rad * np.arange(len(angle)) * coarse.period_s
    assert np.abs(angle - reference)[2000:].max() < 1.5 * count_rad


def test_three_joints_are_three_laws(fine) -> None:
    both = AccelerationControl(fine)
    alone = [JointLaw(fine) for _ in range(3)]
    both.reset((0.1, 0.2, 0.3), (1, 2, 3))
    for law, reference, count in zip(alone, (0.1, 0.2, 0.3), (1, 2, 3), strict=True):
        law.reset(reference, count)
    for tick in range(50):
        references, counts = (0.1, 0.2 + 1e-5 * tick, 0.3), (tick, 2, -tick)
        expected = [law.tick(*each) for law, *each in zip(alone, references, counts, strict=True)]
        assert list(both.tick(references, counts)) == expected
    for law, same in zip(alone, both.joints, strict=True):
        assert (same.current_a, same.disturbance_a) == (law.current_a, law.disturbance_a)
