"""Block by block must give what the whole recording gives, for every effect."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from deltactl.models.chain import Chain, Commands, OnlineChain
from deltactl.models.effects import VOCABULARY
from deltactl.models.robot import DeltaRobot, EffectEntry

EXAMPLES: dict[str, dict[str, float | tuple[float, ...]]] = {
    "following_lag": {"time": 0.07, "dead_time": 0.033},
    "lost_steps": {"steps": 40.0, "time": 2.0},
    "gear_ratio": {"scale": 1.01},
    "transmission_error": {"amplitude": 0.004, "period": 0.6, "phase": 0.4},
    "encoder_error": {"amplitude": 0.004, "period": 0.6},
    "gear_backlash": {"width": 0.02, "drag": 8.0, "friction": 0.2},
    "joint_friction": {"width": 0.02, "asymmetry": 0.2, "start": 0.5, "stiffness": 2e3},
    "viscous_friction": {"coefficient": 20.0},
    "joint_compliance": {"stiffness": 300.0},
    "payload": {"mass": 0.5},
    "home_offset": {"angle": 0.01},
    "upper_arm_length": {"length_error": 0.002},
    "forearm_length": {"length_error": -0.002},
    "base_radius": {"length_error": 0.003},
    "motor_azimuth": {"angle": 0.02},
    "thermal_expansion": {"strain": 0.01, "time_constant": 3.0},
    "contact": {"height": -0.35, "grip": 1.5},
    "resonance": {"frequency": 2.0, "damping": 0.1},
    "frame_tilt": {"rotation": (0.01, -0.02, 0.03)},
    "sensor_offset": {"offset": 0.01},
    "sensor_scale": {"scale": 1.02},
    "sensor_crosstalk": {"curvature": 0.02},
    "sensor_drift": {"offset": 0.01, "time_constant": 2.0},
    "sensor_latency": {"time": 0.137},
    "stale_reading": {"time": 1.9, "duration": 0.8},
}


def entry(name: str) -> EffectEntry:
    """One example of an effect, on the first component that takes it."""
    component = VOCABULARY[name].components[0]
    return EffectEntry(effect=name, component=component, parameters=EXAMPLES[name])


def test_every_effect_has_an_example() -> None:
    assert set(EXAMPLES) == set(VOCABULARY)


@pytest.mark.parametrize("name", sorted(VOCABULARY))
def test_blocks_give_what_the_whole_gives(
    name: str, robot: DeltaRobot, motion: tuple[np.ndarray, np.ndarray]
) -> None:
    t_s, counts = motion
    assert robot.drive is not None
    whole = Chain.delta(robot).simulate(Commands.of_counts(t_s, counts, robot.drive), [entry(name)])
    online = OnlineChain(robot, [entry(name)])
    edges = [0, 1, 2, 50, 97, 98, 200, len(t_s)]
    parts = [online.advance(t_s[a:b], counts[a:b]) for a, b in itertools.pairwise(edges)]
    for column in range(4):
        joined = np.concatenate([part[column] for part in parts])
        np.testing.assert_allclose(joined, whole[column], atol=1e-12)


@pytest.mark.parametrize("name", sorted(VOCABULARY))
def test_an_effect_changes_something(
    name: str, robot: DeltaRobot, motion: tuple[np.ndarray, np.ndarray]
) -> None:
    t_s, counts = motion
    assert robot.drive is not None
    commands = Commands.of_counts(t_s, counts, robot.drive)
    chain = Chain.delta(robot)
    nominal, changed = chain.simulate(commands), chain.simulate(commands, [entry(name)])
    column = 3 if name == "encoder_error" else 2
    assert np.abs(nominal[column] - changed[column]).max() > 1e-4
