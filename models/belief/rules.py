"""How two effects of one kind at one component add up to one, for each effect of the vocabulary."""

from __future__ import annotations

from enum import Enum


class Rule(Enum):
    """What the main parameter of both together is."""

    SUM = "sum"
    PRODUCT = "product"
    SERIES = "series"
    """1 / k = 1 / k1 + 1 / k2, as springs one behind the other."""
    PHASOR = "phasor"
    """Sine waves of one period; of two periods both stay."""
    RATE = "rate"
    """Size per stiffness adds up, at the stiffness that was believed."""
    TABLE = "table"
    """Tables over one quantity add up; beyond its ends a table is constant."""


RULES: dict[str, Rule] = {
    "following_lag": Rule.SUM,
    "gear_ratio": Rule.PRODUCT,
    "transmission_error": Rule.PHASOR,
    "encoder_error": Rule.PHASOR,
    "gear_backlash": Rule.SUM,
    "joint_friction": Rule.SUM,
    "viscous_friction": Rule.RATE,
    "joint_compliance": Rule.SERIES,
    "payload": Rule.RATE,
    "home_offset": Rule.SUM,
    "upper_arm_length": Rule.SUM,
    "forearm_length": Rule.SUM,
    "base_radius": Rule.SUM,
    "motor_azimuth": Rule.SUM,
    "thermal_expansion": Rule.SUM,
    "frame_tilt": Rule.SUM,
    "sensor_offset": Rule.SUM,
    "sensor_scale": Rule.PRODUCT,
    "sensor_crosstalk": Rule.SUM,
    "sensor_drift": Rule.SUM,
    "sensor_latency": Rule.SUM,
    "joint_table": Rule.TABLE,
    "platform_table": Rule.TABLE,
}
"""Of effects that are not here (resonance, contact) the newest is kept. Widths of play and of
wound-up shafts in series add up exactly (Brokate and Sprekels 1996, stop and play operators),
lags and small rotations to first order."""
ALSO_SUMMED = {"following_lag": "dead_time"}
"""A second parameter that adds up as well."""
