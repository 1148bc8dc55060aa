"""The vocabulary of single axes and lone sensors: the same operators on a component `axis`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Literal

from deltactl.models.effects import (
    axis_inertia,
    axis_latency,
    axis_play,
    axis_resonance,
    axis_viscous,
    coulomb_friction,
    effort_gain,
    effort_offset,
    encoder_error,
    following_lag,
    gear_ratio,
    home_offset,
    joint_compliance,
    lost_steps,
    periodic,
    sensor_crosstalk,
    sensor_drift,
    sensor_offset,
    sensor_scale,
    stribeck_friction,
    transmission_error,
    viscous_friction,
)
from deltactl.models.effects.kind import EffectKind, Parameter

Motion = Literal["linear", "rotary"]
COMPONENT = "axis"
LINEAR_UNIT = {
    "rad": "m", "N m": "N", "kg m2": "kg", "N m s/rad": "N s/m", "N m/rad": "N/m", "rad/s": "m/s",
}  # fmt: skip
"""Linear axes use m, N, kg in place of rad, N m, kg m2 (contract)."""

FINEST = 1e-6
"""Shortest period [rad, m]: of a scale's grating, or of a motor's turns behind a high reduction."""

_WAVE = replace(
    transmission_error.EFFECT,
    order=4,
    parameters=(*transmission_error.EFFECT.parameters, *periodic.SECOND),
)
"""Behind the play: by where the axis is, as readings of it show a wave."""
_SCALE = replace(
    encoder_error.EFFECT, parameters=(*encoder_error.EFFECT.parameters, *periodic.SECOND)
)

_COMMAND = (
    following_lag.EFFECT, lost_steps.EFFECT, gear_ratio.EFFECT, _WAVE,
    axis_play.BACKLASH, axis_play.FRICTION, viscous_friction.EFFECT, joint_compliance.EFFECT,
    home_offset.EFFECT, axis_resonance.EFFECT, _SCALE, axis_latency.EFFECT,
)  # fmt: skip
_EFFORT = (
    following_lag.EFFECT, effort_gain.EFFECT, effort_offset.EFFECT, coulomb_friction.EFFECT,
    axis_viscous.EFFECT, stribeck_friction.EFFECT, axis_inertia.EFFECT,
)  # fmt: skip
_SENSOR = (
    sensor_offset.EFFECT, sensor_scale.EFFECT, sensor_crosstalk.EFFECT, sensor_drift.EFFECT,
    replace(axis_latency.EFFECT),
)  # fmt: skip


def _unit(unit: str, motion: Motion) -> str:
    return LINEAR_UNIT.get(unit, unit) if motion == "linear" else unit


def of_axis(
    kind: EffectKind, motion: Motion, sentences: Mapping[str, str] = MappingProxyType({})
) -> EffectKind:
    """A kind on the component `axis`, with the units of its motion; sentences: its own, by name."""
    own = {**(_SLIDING if motion == "linear" else {}), **sentences}
    parameters = tuple(
        replace(p, unit=_unit(p.unit, motion), low=FINEST if p.name == "period" else p.low)
        for p in kind.parameters
    )
    return replace(
        kind,
        components=(COMPONENT,),
        parameters=parameters,
        says=lambda component, values: _sentence(kind.name, parameters, values, own),
    )


def command_effects(motion: Motion) -> dict[str, EffectKind]:
    """What can be wrong with an axis that follows a command."""
    return {kind.name: of_axis(kind, motion) for kind in _COMMAND}


def effort_effects(motion: Motion) -> dict[str, EffectKind]:
    """What can be wrong with an axis that is driven by effort."""
    return {kind.name: of_axis(kind, motion, _OF_EFFORT) for kind in _EFFORT}


def sensor_effects() -> dict[str, EffectKind]:
    """What can be wrong with a range sensor by itself."""
    return {kind.name: of_axis(kind, "linear") for kind in _SENSOR}


def forms_of(effect: str) -> list[EffectKind]:
    """What an effect can be on a lone machine: friction is a torque beside effort, else a width."""
    return [kind for kind in (*_COMMAND, *_EFFORT, *_SENSOR) if kind.name == effect]


_WORDS = {
    "following_lag": "the axis follows late, with a time constant of {time}",
    "lost_steps": "the motor lost {steps} at {time} and stayed behind",
    "gear_ratio": "the axis moves {scale} times as far as commanded",
    "transmission_error": "the gear adds a periodic error of {amplitude} every {period}",
    "encoder_error": "the encoder adds a periodic error of {amplitude} every {period}",
    "gear_backlash": "between drive and axis there is free play of {width} in all",
    "viscous_friction": "friction of {coefficient} grows with the speed of the axis",
    "joint_compliance": "the axis yields under load, with a stiffness of {stiffness}",
    "home_offset": "the axis stands {angle} {side} where it should",
    "resonance": "the axis rings at {frequency} after moves, with a damping of {damping}",
    "sensor_latency": "the readings are late by {time}",
    "effort_gain": "the drive gives {scale} times the force that the robot file says",
    "effort_offset": "a constant {offset} of the effort is there whichever way the axis moves: it"
    " holds against a weight or a slope, or the effort's zero is off",
    "stribeck_friction": "friction is {torque} higher near standstill, falling off within {speed}",
    "inertia": "the moment of inertia of what the axis turns is {inertia}",
    "sensor_scale": "the sensor reads {scale} times the distance",
    "sensor_drift": "the sensor drifts by {offset} with a time constant of {time_constant}",
}
_OF_EFFORT = {
    "following_lag": "the motion comes {dead_time} later than the effort that makes it",
}
_SLIDING = {
    "inertia": "the axis moves a mass of {inertia}",
    "transmission_error": "the screw or belt adds a periodic error of {amplitude} every {period}",
    "encoder_error": "the scale or encoder adds a periodic error of {amplitude} every {period}",
}
_FRICTION = {
    "width": "friction holds the axis back by {width} in all between its two directions",
    "torque": "dry (Coulomb) friction of {torque} brakes the axis, always against its motion",
}
FEW_DEGREES = 0.02
"""Below it people who have such angles count seconds of arc."""
SQUARE_METRE = "m\u00b2"
_SMALL = {"m": ("mm", 1e3), "s": ("ms", 1e3)}


def said(value: float, unit: str) -> str:
    """A number with a unit in which it is easily read: angles in degrees, as everywhere else."""
    if unit == "1":
        near_one = abs(value - 1.0)
        digits = 3 - math.floor(math.log10(near_one)) if 0.0 < near_one < 1e-3 else 5
        return f"{value:.{digits}g}"
    if unit == "rad":
        degrees = math.degrees(value)
        fine = f" ({plain(3600.0 * degrees)} seconds of arc)" if abs(degrees) < FEW_DEGREES else ""
        return f"{plain(degrees)} degrees{fine}"
    if unit in _SMALL and abs(value) < 1.0:
        unit, factor = _SMALL[unit]
        value *= factor
    return f"{plain(value)} {unit.replace('m2', SQUARE_METRE)}"


def plain(value: float, digits: int = 3) -> str:
    """So many significant digits, and no exponent where a person would write none."""
    if not math.isfinite(value) or value == 0.0 or not 1e-5 <= abs(value) < 1e6:
        return f"{value:.{digits}g}"
    decimals = digits - 1 - math.floor(math.log10(abs(value)))
    return f"{value:.{max(decimals, 0)}f}"


def _sentence(
    name: str,
    parameters: tuple[Parameter, ...],
    values: Mapping[str, Any],
    own: Mapping[str, str],
) -> str:
    shown = {p.name: said(float(values[p.name]), p.unit) for p in parameters if p.name in values}
    if name == "sensor_crosstalk":
        return sensor_crosstalk.EFFECT.says("the sensor", values)
    if name == "sensor_offset":
        way = "too far" if float(values["offset"]) > 0.0 else "short"
        return f"the sensor reads {said(abs(float(values['offset'])), 'm')} {way}"
    if name == "home_offset":
        angle = float(values["angle"])
        shown |= {"side": "above" if angle > 0.0 else "below"}
        shown["angle"] = said(abs(angle), next(p.unit for p in parameters if p.name == "angle"))
    words = (
        own.get(name) or _WORDS.get(name) or _FRICTION["width" if "width" in shown else "torque"]
    )
    text = words.format(**shown)
    if name == "following_lag" and name not in own and float(values.get("dead_time", 0.0)):
        dead = f"a dead time of {shown['dead_time']}"
        text = f"{text} after {dead}" if float(values["time"]) else f"the axis follows after {dead}"
    if float(values.get("asymmetry", 0.0)):
        text += f", with an asymmetry of {values['asymmetry']:+.2f}"
    return text
