"""Operators against calculations by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.foundation.errors import ConfigError
from deltactl.models.chain import Chain, Commands
from deltactl.models.chain.active import activate
from deltactl.models.chain.axis import gravity_pull
from deltactl.models.effects import effect_kind
from deltactl.models.robot import AxisGravity, DeltaRobot, EffectEntry, ServoAxis
from deltactl.models.signals import by_doubling, by_substitution, clipped, lagged, linear


def _run(robot: DeltaRobot, t_s: np.ndarray, angles: np.ndarray, **effect: object) -> np.ndarray:
    entry = EffectEntry.model_validate(effect)
    return Chain(robot).simulate(Commands.of_angles(t_s, angles), [entry]).theta


@pytest.mark.study
@given(st.lists(st.floats(-1, 1), min_size=1, max_size=60), st.floats(0, 0.99))
def test_linear_recursion_is_the_loop(values: list[float], gain: float) -> None:
    x, expected = 0.3, []
    for value in values:
        x = gain * x + value
        expected.append(x)
    addend = np.array(values)[:, None]
    result = linear(np.full(len(values), gain), addend, np.array([0.3]))
    np.testing.assert_allclose(result[:, 0], expected, atol=1e-12)


@given(st.integers(1, 70), st.integers(0, 2**31), st.booleans())
def test_linear_recursion_needs_no_scipy(samples: int, seed: int, whole: bool) -> None:
    rng = np.random.default_rng(seed)
    gain = rng.uniform(0.0, 1.0, samples) * np.exp(0 if whole else 1j * rng.uniform(0, 6, samples))
    gain[rng.random(samples) < 0.1] = 0.0
    total = rng.standard_normal((samples, 3)) + (0.0 if whole else 1j)
    np.testing.assert_allclose(
        by_doubling(gain, total.copy()), by_substitution(gain, total), atol=1e-12
    )


@given(
    st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(0, 1)), min_size=1),
    st.floats(-2, 2),
)
def test_clipped_recursion_is_the_loop(
    rows: list[tuple[float, float, float]], before: float
) -> None:
    move, low, high = np.array([(m, lo, lo + w) for m, lo, w in rows]).T
    x, expected = before, []
    for m, lo, hi in zip(move, low, high, strict=True):
        x = min(hi, max(lo, x + m))
        expected.append(x)
    np.testing.assert_allclose(clipped(move, low, high, before), expected, atol=1e-12)


def test_lag_of_a_ramp_is_late_by_its_time_constant() -> None:
    t_s = 0.01 * np.arange(1000)
    step = np.full(1000, 0.01)
    step[0] = 0.0
    y = lagged(2.0 * t_s[:, None], step, 0.3, {})
    assert y[-1, 0] == pytest.approx(2.0 * (t_s[-1] - 0.3), abs=1e-9)


def test_home_offset_adds_the_angle(robot: DeltaRobot) -> None:
    theta = _run(
        robot, np.arange(3.0), np.full((3, 3), 0.5),
        effect="home_offset", component="motor2", parameters={"angle": 0.01},
    )  # fmt: skip
    np.testing.assert_allclose(theta, [[0.5, 0.51, 0.5]] * 3)


def test_lost_steps_fall_short_after_their_time(robot: DeltaRobot) -> None:
    theta = _run(
        robot, np.arange(4.0), np.full((4, 3), 0.5),
        effect="lost_steps", component="motor1", parameters={"steps": 32.0, "time": 2.0},
    )  # fmt: skip
    step_rad = 2 * np.pi / 16000
    np.testing.assert_allclose(theta[:, 0], [0.5, 0.5, 0.5 - 32 * step_rad, 0.5 - 32 * step_rad])


def test_backlash_hangs_on_the_flank_gravity_pulls_to(robot: DeltaRobot) -> None:
    theta = _run(
        robot, 0.02 * np.arange(50), np.full((50, 3), 0.5),
        effect="gear_backlash", component="motor3", parameters={"width": 0.01},
    )  # fmt: skip
    np.testing.assert_allclose(theta[:, 2], 0.505, atol=1e-12)


def test_a_fast_motor_outruns_the_falling_arm(robot: DeltaRobot) -> None:
    t_s = 0.02 * np.arange(100)
    angles = np.tile(0.2 + 0.5 * t_s[:, None], (1, 3))
    angles[50:] = angles[50]
    parameters = {"width": 0.01, "drag": 10.0}
    theta = _run(
        robot, t_s, angles, effect="gear_backlash", component="motor1", parameters=parameters
    )
    assert theta[40, 0] - angles[40, 0] == pytest.approx(-0.005)
    assert theta[99, 0] - angles[99, 0] == pytest.approx(0.005)


def test_friction_is_the_play_operator(robot: DeltaRobot) -> None:
    path = np.array([0.0, 1.0, 0.5, 0.2, 0.9, 1.4]) * 0.1
    angles = np.tile(path[:, None], (1, 3))
    theta = _run(
        robot, np.arange(6.0), angles,
        effect="joint_friction", component="motor1", parameters={"width": 0.04},
    )  # fmt: skip
    np.testing.assert_allclose(theta[:, 0], [0.0, 0.08, 0.07, 0.04, 0.07, 0.12], atol=1e-12)


def test_compliance_yields_by_torque_over_stiffness(robot: DeltaRobot) -> None:
    chain = Chain(robot)
    commands = Commands.of_angles(np.arange(2.0), np.full((2, 3), 0.5))
    torque = chain.course(commands).load().torque_nm
    entry = EffectEntry(
        effect="joint_compliance", component="joints", parameters={"stiffness": 200.0}
    )
    np.testing.assert_allclose(
        chain.simulate(commands, [entry]).theta, 0.5 + torque / 200.0, atol=1e-14
    )


def test_sensor_effects_by_hand(robot: DeltaRobot) -> None:
    chain = Chain(robot)
    commands = Commands.of_angles(np.arange(2.0), np.full((2, 3), 0.5))
    nominal = chain.simulate(commands).ranges
    scaled = chain.simulate(
        commands,
        [EffectEntry(effect="sensor_scale", component="range_z", parameters={"scale": 1.02})],
    ).ranges
    np.testing.assert_allclose(scaled[:, 2], 1.02 * nominal[:, 2])
    np.testing.assert_allclose(scaled[:, :2], nominal[:, :2])


@pytest.mark.parametrize(
    ("component", "parameters", "words"),
    [
        ("motor4", {"angle": 0.1}, "motor1, motor2, motor3"),
        ("motor1", {"angel": 0.1}, "angel"),
        ("motor1", {}, "is needed"),
        ("motor1", {"angle": 3.0}, "between"),
    ],
)
def test_wrong_entries_say_what_is_possible(
    component: str, parameters: dict[str, float], words: str
) -> None:
    with pytest.raises(ConfigError, match=words):
        activate(effect_kind("home_offset"), component, parameters)


def test_sentences_give_size_and_unit() -> None:
    words = effect_kind("gear_backlash").sentence("motor2", {"width": 0.0087})
    assert "motor2" in words
    assert "0.498 degrees" in words


def test_a_slope_pulls_a_slide_the_same_everywhere() -> None:
    at_m = np.linspace(-2.0, 3.0, 7)
    assert gravity_pull(AxisGravity(force_n=12.0), at_m) == pytest.approx(-12.0)
    slope = {"kind": "servo_axis", "name": "s", "gravity": {"force_n": 12.0}}
    assert ServoAxis.model_validate(slope | {"motion": "linear"}).gravity is not None
    with pytest.raises(ValueError, match="enter torque_nm"):
        ServoAxis.model_validate(slope | {"motion": "rotary"})


def test_a_weight_on_a_rope_pulls_a_drum_the_same_at_every_angle() -> None:
    at_rad = np.linspace(-7.0, 40.0, 9)
    assert gravity_pull(AxisGravity(constant_nm=0.9), at_rad) == pytest.approx(-0.9)
    drum = {"kind": "servo_axis", "name": "s", "gravity": {"constant_nm": 0.9}}
    assert ServoAxis.model_validate(drum | {"motion": "rotary"}).gravity is not None
    with pytest.raises(ValueError, match="enter force_n"):
        ServoAxis.model_validate(drum | {"motion": "linear"})
