"""Pairs of causes that one recording cannot tell apart, and the motions on which they tie."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from deltactl.proof.hidden.build_in import VOCABULARY, Planned
from deltactl.proof.hidden.hidden import ARMS, MOTORS, Parameters, either_sign

Name = tuple[str, str]
Parts = list[Planned]


@dataclass(frozen=True)
class Tie:
    """Two explanations; one of them is built in. `motion` is one on which they tie."""

    name: str
    motion: str
    build: Callable[[np.random.Generator, int, bool], tuple[Parts, list[Name]]]
    """(rng, arm, first or second) -> what is built in, and the names of the rival."""
    settleable: bool = True
    """Whether a motion can tell them apart at all."""


def _part(effect: str, index: int, **parameters: float) -> Planned:
    values: Parameters = dict(parameters)
    return Planned(VOCABULARY[effect], index, values)


def _play(rng: np.random.Generator, arm: int, first: bool) -> tuple[Parts, list[Name]]:
    width = float(rng.uniform(0.006, 0.010))
    names: list[Name] = [("gear_backlash", MOTORS[arm]), ("joint_friction", MOTORS[arm])]
    if first:
        drag = float(rng.uniform(6.0, 15.0))
        return [_part("gear_backlash", arm, width=width, friction=0.05, drag=drag)], names[1:]
    return [_part("joint_friction", arm, width=width)], names[:1]


def _late(rng: np.random.Generator, _: int, first: bool) -> tuple[Parts, list[Name]]:
    late_s = float(rng.uniform(0.08, 0.16))
    if first:
        lags = [_part("following_lag", m, time=0.0, dead_time=late_s) for m in range(3)]
        return lags, [("sensor_latency", "sensors")]
    return [_part("sensor_latency", 0, time=late_s)], [("following_lag", m) for m in MOTORS]


def _one_way(rng: np.random.Generator, arm: int, first: bool) -> tuple[Parts, list[Name]]:
    if first:
        lag = _part("following_lag", arm, time=float(rng.uniform(0.08, 0.16)), dead_time=0.0)
        return [lag], [("motor_azimuth", MOTORS[arm])]
    azimuth = _part("motor_azimuth", arm, angle=either_sign(rng, 0.012, 0.024))
    return [azimuth], [("following_lag", MOTORS[arm])]


def _one_arm(rng: np.random.Generator, arm: int, first: bool) -> tuple[Parts, list[Name]]:
    if first:
        home = _part("home_offset", arm, angle=either_sign(rng, 0.010, 0.018))
        return [home], [("forearm_length", ARMS[arm])]
    length = _part("forearm_length", arm, length_error=either_sign(rng, 0.003, 0.005))
    return [length], [("home_offset", MOTORS[arm])]


def _height(rng: np.random.Generator, _: int, first: bool) -> tuple[Parts, list[Name]]:
    if first:
        angle = either_sign(rng, 0.010, 0.018)
        homes = [_part("home_offset", m, angle=angle) for m in range(3)]
        return homes, [("sensor_offset", "range_z")]
    offset = _part("sensor_offset", 2, offset=either_sign(rng, 0.003, 0.006))
    return [offset], [("home_offset", m) for m in MOTORS]


def _sag(rng: np.random.Generator, _: int, first: bool) -> tuple[Parts, list[Name]]:
    if first:
        error = either_sign(rng, 0.001, 0.002)
        lengths = [_part("upper_arm_length", a, length_error=error) for a in range(3)]
        return lengths, [("joint_compliance", "joints")]
    soft = _part("joint_compliance", 0, stiffness=float(rng.uniform(250.0, 450.0)))
    return [soft], [("upper_arm_length", a) for a in ARMS]


TIES = (
    Tie("backlash or friction wind-up", "survey", _play),
    Tie("drive lag or sensor latency", "survey", _late, settleable=False),
    Tie("arm lag or motor azimuth", "circle", _one_way),
    Tie("home offset or forearm length", "circle", _one_arm),
    Tie("all homes or z sensor offset", "circle", _height),
    Tie("upper arms or compliance", "circle", _sag),
)
