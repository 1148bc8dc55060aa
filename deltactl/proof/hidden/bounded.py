"""Sensors with a limit or a memory of their own, in no vocabulary."""

from __future__ import annotations

import numpy as np

from deltactl.proof.hidden.hidden import Hidden
from deltactl.proof.hidden.oddities import AXES, at_sensor, drawn_at, sensor_answer
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import FloatArray

MIDDLE_M = (0.60, 0.60, 0.50)
"""Distances in the middle of a survey."""


def _own(index: int) -> str:
    return f"range_{AXES[index]}"


def saturation(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """Beyond some distance a sensor falls short, the more the farther, up to its size."""
    d = drawn_at(rng, 0.012, 0.020, strength)
    # A survey goes three times as far in z as across.
    stretch = (1.0, 1.0, 3.0)[d.index]
    limit_m = MIDDLE_M[d.index] + stretch * float(rng.uniform(-0.02, 0.01))

    def short(t_s: FloatArray, ranges: FloatArray, speed: FloatArray) -> FloatArray:
        beyond = np.maximum(ranges[:, d.index] - limit_m, 0.0)
        error: FloatArray = d.size * np.expm1(-beyond / (0.05 * stretch))
        return error

    machine.sensors.quirks.append(at_sensor(d.index, short))
    return sensor_answer(d, "saturation", [_own(d.index)])


def coarse_steps(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A sensor's linearisation holds its value over steps of a centimetre or more."""
    d = drawn_at(rng, 0.012, 0.018, strength)

    def stairs(t_s: FloatArray, ranges: FloatArray, speed: FloatArray) -> FloatArray:
        own = ranges[:, d.index]
        error: FloatArray = d.size * np.round(own / d.size) - own
        return error

    machine.sensors.quirks.append(at_sensor(d.index, stairs))
    return sensor_answer(d, "coarse_steps", [_own(d.index)])


def multipath(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """At some distances the echo of a wall mixes in and the sensor reads long."""
    d = drawn_at(rng, 0.008, 0.014, strength)
    place_m = MIDDLE_M[d.index] + float(rng.uniform(-0.04, 0.04))

    def long(t_s: FloatArray, ranges: FloatArray, speed: FloatArray) -> FloatArray:
        mixed: FloatArray = np.exp(-(((ranges[:, d.index] - place_m) / 0.025) ** 2))
        return d.size * mixed

    machine.sensors.quirks.append(at_sensor(d.index, long))
    return sensor_answer(d, "multipath", [_own(d.index)])


def mean_filter(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """One sensor alone gives the mean of its last few tenths of a second."""
    d = drawn_at(rng, 0.2, 0.4, strength)

    def behind(t_s: FloatArray, ranges: FloatArray, speed: FloatArray) -> FloatArray:
        own = ranges[:, d.index]
        length = max(1, round(d.size / (t_s[1] - t_s[0])))
        total = np.cumsum(np.concatenate([np.full(length, own[0]), own]))
        error: FloatArray = (total[length:] - total[:-length]) / length - own
        return error

    machine.sensors.quirks.append(at_sensor(d.index, behind))
    own = AXES[d.index]
    return sensor_answer(d, "mean_filter", [f"speed_{own}", f"speed_range_{own}"], True, "s")


def sticky(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A sensor repeats its reading until the distance has changed by more than a dead band."""
    d = drawn_at(rng, 0.012, 0.018, strength)

    def held(t_s: FloatArray, ranges: FloatArray, speed: FloatArray) -> FloatArray:
        own = ranges[:, d.index]
        given: FloatArray = np.empty_like(own)
        last = float(own[0])
        for k, value in enumerate(own.tolist()):
            if abs(value - last) > d.size:
                last = value
            given[k] = last
        given -= own
        return given

    machine.sensors.quirks.append(at_sensor(d.index, held))
    own = AXES[d.index]
    follows = [_own(d.index), f"speed_{own}", f"speed_range_{own}"]
    return sensor_answer(d, "sticky", follows, True)
