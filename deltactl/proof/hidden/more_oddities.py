"""The second set of causes in no vocabulary: limits of sensors, forces, wear, heat.

Half are kept out of sight: whoever tunes the diagnosis runs, reads and plots only those that are
seen. They alternate in the alphabet, so that nobody chose. Forces need soft joints to be seen; how
soft the joints are is a named effect, and right to name beside the force.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter

from deltactl.proof.hidden.hidden import Hidden
from deltactl.proof.hidden.oddities import (
    AXES,
    ODDITIES,
    TWO_PI,
    Build,
    at_joint,
    at_sensor,
    drawn_at,
    motor_answer,
    sensor_answer,
    unknown,
)
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


SOFT_NM_PER_RAD = (300.0, 500.0)
PLACES = tuple(f"range_{axis}" for axis in AXES)
SPEEDS = tuple(f"speed_{axis}" for axis in AXES) + tuple(f"speed_range_{axis}" for axis in AXES)


def _soften(machine: Machine, rng: np.random.Generator) -> None:
    stiffness = machine.robot.joints.stiffness_nm_per_rad
    np.minimum(stiffness, float(rng.uniform(*SOFT_NM_PER_RAD)), out=stiffness)


def _answer(
    kind: str,
    size: float,
    unit: str,
    depends_on: tuple[str, ...],
    memory: bool | None = False,
    also_where: tuple[str, ...] = (),
) -> Hidden:
    return replace(
        unknown(kind, "platform", size, unit, memory),
        also_where=("frame", "joints", *also_where),
        depends_on=depends_on,
        through=(("joint_compliance", "joints"),),
    )


def _around(rng: np.random.Generator, radius_m: float, height_m: float) -> FloatArray:
    """A point at a drawn direction from the middle, (3,) [m]."""
    way = float(rng.uniform(0.0, TWO_PI))
    return np.array([radius_m * np.cos(way), radius_m * np.sin(way), height_m])


def _tension(
    anchor_m: FloatArray, rest_m: float, n_per_m: float, position_m: FloatArray, slack: bool
) -> FloatArray:
    """Elastic force towards an anchor, (n, 3) [N]; what may be slack cannot push."""
    away = anchor_m - position_m
    length_m = np.linalg.norm(away, axis=1, keepdims=True)
    longer_m = length_m - rest_m
    longer_m = np.maximum(longer_m, 0.0) if slack else longer_m
    force: FloatArray = n_per_m * longer_m * away / length_m
    return force


def elastic_cable(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A cable pulls towards a point of the frame; nearer than its length it hangs loose."""
    _soften(machine, rng)
    anchor_m = _around(rng, float(rng.uniform(0.25, 0.35)), float(rng.uniform(-0.3, -0.1)))
    size, rest_m = strength * float(rng.uniform(150.0, 250.0)), float(rng.uniform(0.2, 0.26))
    machine.robot.body.pulls.append(lambda t, r, v: _tension(anchor_m, rest_m, size, r, slack=True))
    return _answer("elastic_cable", size, "N/m", PLACES)


def spring_to_frame(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A spring between platform and frame, which pulls and pushes."""
    _soften(machine, rng)
    anchor_m = _around(rng, float(rng.uniform(0.15, 0.25)), float(rng.uniform(-0.45, -0.3)))
    size, rest_m = strength * float(rng.uniform(150.0, 250.0)), float(rng.uniform(0.18, 0.26))
    machine.robot.body.pulls.append(
        lambda t, r, v: _tension(anchor_m, rest_m, size, r, slack=False)
    )
    return _answer("spring_to_frame", size, "N/m", PLACES)


def magnet(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A magnet near one place draws the platform in from a few centimetres around."""
    _soften(machine, rng)
    place_m = _around(rng, float(rng.uniform(0.0, 0.05)), float(rng.uniform(-0.45, -0.38)))
    size, reach_m = strength * float(rng.uniform(25.0, 40.0)), 0.08

    def pull(t_s: FloatArray, position_m: FloatArray, speed: FloatArray) -> FloatArray:
        away = (place_m - position_m) / reach_m
        square = np.sum(away**2, axis=1, keepdims=True)
        # 2.6 (3^1.5 / 2) makes the size the largest force, which is at 0.7 of the reach.
        force: FloatArray = 2.6 * size * away / (1.0 + square) ** 1.5
        return force

    machine.robot.body.pulls.append(pull)
    return _answer("magnet", size, "N", PLACES)


def drag(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """Something is dragged along: a force against the motion, hardly larger when it is fast."""
    _soften(machine, rng)
    size = strength * float(rng.uniform(15.0, 25.0))

    def pull(t_s: FloatArray, position_m: FloatArray, speed: FloatArray) -> FloatArray:
        fast = np.linalg.norm(speed, axis=1, keepdims=True)
        force: FloatArray = -size * np.tanh(fast / 0.02) * speed / np.maximum(fast, 1e-9)
        return force

    machine.robot.body.pulls.append(pull)
    return _answer("drag", size, "N", SPEEDS, memory=None)


def gusts(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """Wind from one side swells and falls within seconds."""
    _soften(machine, rng)
    size, way = strength * float(rng.uniform(30.0, 45.0)), _around(rng, 1.0, 0.0)
    rates_hz, phases = rng.uniform(0.03, 0.3, 4), rng.uniform(0.0, TWO_PI, 4)

    def pull(t_s: FloatArray, position_m: FloatArray, speed: FloatArray) -> FloatArray:
        waves = np.sin(TWO_PI * np.outer(t_s, rates_hz) + phases)
        force: FloatArray = size * np.outer(0.5 + 0.25 * waves.sum(axis=1), way)
        return force

    machine.robot.body.pulls.append(pull)
    return _answer("gusts", size, "N", ("time",), also_where=("range_x", "range_y"))


WORN_HALF_RAD, DUSTY_HALF_M = 5.0, 6.0
"""Travel after which half of what wear and dust can do has been done: within a minute or two."""
TURNING_RAD_S = 0.02


def _slowly(signal: FloatArray, t_s: FloatArray, tau_s: float, start: float) -> FloatArray:
    """First-order memory of a signal on evenly spaced times."""
    keep = float(np.exp(-(t_s[1] - t_s[0]) / tau_s))
    slow: FloatArray = lfilter([1.0 - keep], [1.0, -keep], signal, zi=[keep * start])[0]
    return slow


def _travelled(path: FloatArray) -> FloatArray:
    """Way gone so far, (n,), of one coordinate (n,)."""
    gone: FloatArray = np.cumsum(np.abs(np.diff(path, prepend=path[0])))
    return gone


def wear(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A gear's play grows with what it has turned, behind a bearing that sticks."""
    d = drawn_at(rng, 0.030, 0.045, strength)
    joints = machine.robot.joints
    joints.friction_nm[d.index] = 2.5

    def width(q: FloatArray, t_s: FloatArray) -> FloatArray:
        played, gone = np.zeros_like(q), _travelled(q[:, d.index])
        played[:, d.index] = d.size * gone / (gone + WORN_HALF_RAD)
        return played

    joints.play_shape = width
    motor = d.index + 1
    return motor_answer(d, "wear", ["time", f"theta_{motor}", f"speed_{motor}"], memory=True)


def motor_heat(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A motor warms its mount while it turns and lets it cool while it rests: the arm sinks."""
    d = drawn_at(rng, 0.040, 0.060, strength)
    tau_s = float(rng.uniform(15.0, 30.0))

    def sink(q: FloatArray, t_s: FloatArray) -> FloatArray:
        speed = uniform_filter1d(np.gradient(q[:, d.index], t_s), 40, mode="nearest")
        turning = np.tanh(np.abs(speed) / TURNING_RAD_S)
        return d.size * _slowly(turning, t_s, tau_s, 0.0)

    machine.robot.joints.bends.append(at_joint(d.index, sink))
    return motor_answer(d, "motor_heat", ["time", f"speed_{d.index + 1}"], memory=True)


def belt_creep(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A belt gives the last few per cent of every move over seconds."""
    d = drawn_at(rng, 0.03, 0.06, strength)
    tau_s = float(rng.uniform(3.0, 8.0))

    def behind(q: FloatArray, t_s: FloatArray) -> FloatArray:
        own = q[:, d.index]
        return d.size * (_slowly(own, t_s, tau_s, float(own[0])) - own)

    machine.robot.joints.bends.append(at_joint(d.index, behind))
    motor = d.index + 1
    return motor_answer(d, "belt_creep", [f"theta_{motor}", f"speed_{motor}"], memory=True)


def dust(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """Dust that the motion stirs up settles on a sensor; far targets read shorter and shorter."""
    d = drawn_at(rng, 0.014, 0.022, strength)

    def short(t_s: FloatArray, ranges: FloatArray, speed: FloatArray) -> FloatArray:
        gone = sum((_travelled(ranges[:, axis]) for axis in range(3)), np.zeros(len(t_s)))
        # The echo falls with the square of the distance, the light that dust throws back does not.
        settled = gone / (gone + DUSTY_HALF_M)
        error: FloatArray = -d.size * settled * (ranges[:, d.index] / 0.6) ** 2
        return error

    machine.sensors.quirks.append(at_sensor(d.index, short))
    return sensor_answer(d, "dust", ["time", f"range_{AXES[d.index]}"], memory=True)


@dataclass(frozen=True)
class NewKind:
    """How it is built in, whether it may be looked at, and whether a level curve can show it."""

    build: Build
    seen: bool
    curves: bool


NEW = {
    "belt_creep": NewKind(belt_creep, True, True),
    "coarse_steps": NewKind(coarse_steps, False, False),
    "drag": NewKind(drag, True, False),
    "dust": NewKind(dust, False, True),
    "elastic_cable": NewKind(elastic_cable, True, True),
    "gusts": NewKind(gusts, False, True),
    "magnet": NewKind(magnet, True, False),
    "mean_filter": NewKind(mean_filter, False, False),
    "motor_heat": NewKind(motor_heat, True, False),
    "multipath": NewKind(multipath, False, False),
    "saturation": NewKind(saturation, True, False),
    "spring_to_frame": NewKind(spring_to_frame, False, True),
    "sticky": NewKind(sticky, True, False),
    "wear": NewKind(wear, False, False),
}
SEEN = tuple(name for name, kind in NEW.items() if kind.seen)
UNSEEN = tuple(name for name, kind in NEW.items() if not kind.seen)
SURVEY_ONLY = tuple(name for name, kind in NEW.items() if not kind.curves)
UNKNOWN: dict[str, Build] = {**ODDITIES, **{name: kind.build for name, kind in NEW.items()}}
"""All that is in no vocabulary. Earlier seeds draw from `ODDITIES` alone, which stays as it is."""
