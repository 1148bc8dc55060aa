"""The vocabulary: every effect that can be named, as an operator at a port of the chain.

A new effect is one file with an `EFFECT`, and its line here.
"""

from __future__ import annotations

from deltactl.foundation.errors import ConfigError
from deltactl.models.effects import (
    base_radius,
    contact,
    encoder_error,
    following_lag,
    forearm_length,
    frame_tilt,
    gear_backlash,
    gear_ratio,
    home_offset,
    joint_compliance,
    joint_friction,
    lost_steps,
    motor_azimuth,
    payload,
    resonance,
    sensor_crosstalk,
    sensor_drift,
    sensor_latency,
    sensor_offset,
    sensor_scale,
    stale_reading,
    thermal_expansion,
    transmission_error,
    upper_arm_length,
    viscous_friction,
)
from deltactl.models.effects.kind import EffectKind, Memory, Parameter, Values
from deltactl.models.effects.port import PORT_TEXT, Port
from deltactl.models.effects.tables import JOINT_TABLE, PLATFORM_TABLE

_MODULES = (
    following_lag,
    lost_steps,
    gear_ratio,
    transmission_error,
    gear_backlash,
    joint_friction,
    viscous_friction,
    joint_compliance,
    payload,
    home_offset,
    upper_arm_length,
    forearm_length,
    base_radius,
    motor_azimuth,
    thermal_expansion,
    contact,
    resonance,
    frame_tilt,
    sensor_offset,
    sensor_scale,
    sensor_crosstalk,
    sensor_drift,
    sensor_latency,
    stale_reading,
    encoder_error,
)

VOCABULARY: dict[str, EffectKind] = {module.EFFECT.name: module.EFFECT for module in _MODULES}
"""Effects of a delta by name. Those of single axes stand with their chains."""


TABLES: dict[str, EffectKind] = {kind.name: kind for kind in (JOINT_TABLE, PLATFORM_TABLE)}
"""What a robot file may say of errors that have no name. No diagnosis looks for these."""


def effect_kind(name: str) -> EffectKind:
    """An effect of the vocabulary, or a table. Raises ConfigError naming those there are."""
    if name in TABLES:
        return TABLES[name]
    if name not in VOCABULARY:
        there = ", ".join(sorted([*VOCABULARY, *TABLES]))
        raise ConfigError(f"effect '{name}' must be one of {there}")
    return VOCABULARY[name]


__all__ = [
    "PORT_TEXT",
    "TABLES",
    "VOCABULARY",
    "EffectKind",
    "Memory",
    "Parameter",
    "Port",
    "Values",
    "effect_kind",
]
