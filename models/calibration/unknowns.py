"""What a calibration looks for, and how large each error may well be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.effects.kind import ARM_NAMES, MOTORS, RANGES
from models.robot import EffectEntry, FloatArray


@dataclass(frozen=True)
class Unknown:
    """One number of one effect. `likely` is the standard deviation of what is to be expected.

    A number the samples cannot see stays near its `nothing`; without this, lengths and sensor
    errors that look alike would run away against each other.
    """

    effect: str
    component: str
    parameter: str
    likely: float
    nothing: float = 0.0
    part: int | None = None
    """Which of a vector's numbers."""


def unknowns(waves_per_turn: float) -> tuple[Unknown, ...]:
    """Everything that is looked for on a delta robot with gears, 39 numbers.

    waves_per_turn: how often a gear's error repeats in a turn of the arm (its ratio).
    """
    each = [
        *_of("home_offset", "angle", MOTORS, np.radians(10.0)),
        *_of("upper_arm_length", "length_error", ARM_NAMES, 0.004),
        *_of("forearm_length", "length_error", ARM_NAMES, 0.006),
        Unknown("base_radius", "frame", "length_error", 0.004),
        *_of("motor_azimuth", "angle", MOTORS, np.radians(2.0)),
        *_of("joint_compliance", "yield", MOTORS, 1.0 / 500.0),
        *_of("transmission_error", "sine", MOTORS, 0.001),
        *_of("transmission_error", "cosine", MOTORS, 0.001),
        *(Unknown("frame_tilt", "frame", "rotation", np.radians(1.0), part=k) for k in range(3)),
        *_of("sensor_offset", "offset", RANGES, 0.015),
        *_of("sensor_scale", "scale", RANGES, 0.005, nothing=1.0),
        *_of("sensor_crosstalk", "curvature", RANGES, 0.005),
    ]
    return tuple(each)


def _of(
    effect: str, parameter: str, components: tuple[str, ...], likely: float, nothing: float = 0.0
) -> list[Unknown]:
    return [Unknown(effect, part, parameter, float(likely), nothing) for part in components]


def entries(
    looked_for: tuple[Unknown, ...], values: FloatArray, waves_per_turn: float
) -> tuple[EffectEntry, ...]:
    """Values in units of `likely`, about `nothing`, as effects of a robot file."""
    found: dict[tuple[str, str], dict[str, float]] = {}
    for unknown, value in zip(looked_for, values, strict=True):
        number = unknown.nothing + unknown.likely * float(value)
        name = unknown.parameter if unknown.part is None else str(unknown.part)
        found.setdefault((unknown.effect, unknown.component), {})[name] = number
    return tuple(
        EffectEntry(effect=effect, component=component, parameters=_plain(numbers, waves_per_turn))
        for (effect, component), numbers in found.items()
    )


def _plain(
    numbers: dict[str, float], waves_per_turn: float
) -> dict[str, float | tuple[float, ...]]:
    """In the vocabulary's own parameters: those above are chosen so that 0 is nothing special."""
    if "yield" in numbers:
        # Gears do not push back: what looks like it is a stiff gear.
        return {"stiffness": 1.0 / max(numbers["yield"], 1e-9)}
    if "sine" in numbers:
        sine, cosine = numbers["sine"], numbers["cosine"]
        return {
            "amplitude": float(np.hypot(sine, cosine)),
            "period": 2.0 * np.pi / waves_per_turn,
            "phase": float(np.arctan2(cosine, sine)),
        }
    if "0" in numbers:
        return {"rotation": tuple(numbers[str(k)] for k in range(3))}
    return dict(numbers)
