"""Two effects put together do what both do one after the other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deltactl.models.chain import Chain, Commands
from deltactl.models.merged_effects import merged
from deltactl.models.robot import DeltaRobot, Drive, EffectEntry, Geometry, Masses

ROBOT = DeltaRobot(
    kind="delta",
    name="little",
    geometry=Geometry(base_radius_m=0.3, platform_radius_m=0.1, upper_arm_m=0.25, forearm_m=0.5),
    masses=Masses(upper_arm_kg=0.2, forearm_kg=0.15, platform_kg=0.6),
    drive=Drive(microsteps_per_rev=1600, gear_ratio=10.0),
)
PAIRS = [
    ("home_offset", "motor1", {"angle": 0.02}, {"angle": -0.005}),
    ("gear_ratio", "motor2", {"scale": 1.01}, {"scale": 0.997}),
    ("joint_compliance", "motor3", {"stiffness": 400.0}, {"stiffness": 900.0}),
    ("upper_arm_length", "arm1", {"length_error": 0.002}, {"length_error": 0.001}),
    ("gear_backlash", "motor1", {"width": 0.004, "drag": 1e4}, {"width": 0.002, "drag": 1e4}),
    ("joint_friction", "motor2", {"width": 0.004}, {"width": 0.002}),
    ("transmission_error", "motor1", {"amplitude": 1e-3, "period": 0.6, "phase": 0.3},
     {"amplitude": 5e-4, "period": 0.6, "phase": 2.0}),
    ("payload", "platform", {"mass": 0.4, "stiffness": 500.0}, {"mass": 0.2, "stiffness": 900.0}),
    ("sensor_offset", "range_x", {"offset": 0.01}, {"offset": -0.003}),
    ("sensor_scale", "range_x", {"scale": 1.01}, {"scale": 1.02}),
]  # fmt: skip


def entry(effect: str, component: str, values: dict[str, float]) -> EffectEntry:
    return EffectEntry(effect=effect, component=component, parameters=values)


@pytest.mark.parametrize(("effect", "component", "old", "new"), PAIRS)
def test_one_entry_does_what_two_do(
    effect: str, component: str, old: dict[str, float], new: dict[str, float]
) -> None:
    t_s = np.linspace(0.0, 20.0, 2001)
    wave = 0.6 + 0.3 * np.sin(t_s[:, None] * [0.9, 1.1, 1.3] + [0.0, 2.0, 4.0])
    commands = Commands.of_angles(t_s, wave)
    both = [entry(effect, component, old), entry(effect, component, new)]
    one = merged(both[:1], both[1:])
    assert len(one) == 1
    # In series waves act on angles that differ by a wave: to first order the same.
    expected, seen = (Chain(ROBOT).simulate(commands, effects) for effects in (both, one))
    np.testing.assert_allclose(seen.theta, expected.theta, atol=1e-5)
    np.testing.assert_allclose(seen.ranges, expected.ranges, atol=1e-5)


@given(first=st.floats(-0.1, 0.1), second=st.floats(-0.1, 0.1))
def test_order_and_other_components_do_not_matter(first: float, second: float) -> None:
    one = entry("home_offset", "motor1", {"angle": first})
    other = entry("home_offset", "motor2", {"angle": second})
    assert len(merged([one], [other])) == 2
    there = merged([one], [entry("home_offset", "motor1", {"angle": second})])[0]
    back = merged([entry("home_offset", "motor1", {"angle": second})], [one])[0]
    assert there.parameters["angle"] == pytest.approx(back.parameters["angle"])


def test_waves_of_two_periods_both_stay() -> None:
    once, twice = (
        entry("transmission_error", "motor1", {"amplitude": 1e-3, "period": period})
        for period in (0.6, 0.3)
    )
    assert len(merged([once], [twice])) == 2
