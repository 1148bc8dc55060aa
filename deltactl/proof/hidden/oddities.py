"""Causes that are in no vocabulary: at joints, at the platform and in sensors.

Each says where it sits, what it follows (in the contract's column names, `speed_i` for a
motor's speed, `time`), and whether it has a memory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from deltactl.proof.hidden.hidden import Hidden
from deltactl.proof.ranging import Quirk
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import Bend, FloatArray

Build = Callable[[Machine, np.random.Generator, float], Hidden]
TWO_PI = 2.0 * np.pi
AXES = "xyz"


def at_joint(motor: int, error: Callable[[FloatArray, FloatArray], FloatArray]) -> Bend:
    """An error (n,) of one arm's angle from all angles (n, 3) and times (n,)."""

    def bend(angles: FloatArray, t_s: FloatArray) -> FloatArray:
        added = np.zeros_like(angles)
        added[:, motor] = error(angles, t_s)
        return added

    return bend


def at_sensor(axis: int, error: Quirk) -> Quirk:
    """An error (n,) of one sensor."""

    def quirk(t_s: FloatArray, ranges: FloatArray, speed: FloatArray) -> FloatArray:
        added = np.zeros_like(ranges)
        added[:, axis] = error(t_s, ranges, speed)
        return added

    return quirk


@dataclass(frozen=True)
class Drawn:
    """What most oddities draw first."""

    index: int
    other: int
    size: float
    phase: float


def drawn_at(rng: np.random.Generator, low: float, high: float, strength: float) -> Drawn:
    index = int(rng.integers(3))
    other = int((index + rng.choice([1, 2])) % 3)
    size = float(rng.uniform(low, high)) * strength
    return Drawn(index, other, size, float(rng.uniform(0.0, TWO_PI)))


def unknown(kind: str, where: str, size: float, unit: str, memory: bool | None = False) -> Hidden:
    return Hidden("unknown", where, {"size": size}, "size", unit, memory=memory, kind=kind)


def motor_answer(drawn: Drawn, kind: str, depends_on: list[str], memory: bool = False) -> Hidden:
    made = unknown(kind, f"motor{drawn.index + 1}", drawn.size, "rad", memory)
    return replace(made, also_where=(f"arm{drawn.index + 1}",), depends_on=tuple(depends_on))


def sensor_answer(
    drawn: Drawn, kind: str, depends_on: list[str], memory: bool = False, unit: str = "m"
) -> Hidden:
    made = unknown(kind, f"range_{AXES[drawn.index]}", drawn.size, unit, memory)
    return replace(made, depends_on=tuple(depends_on))


def other_axis(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A sensor errs with where the platform is along another axis."""
    d = drawn_at(rng, 0.003, 0.006, strength)
    machine.sensors.quirks.append(
        at_sensor(d.index, lambda t, r, v: d.size * np.sin(TWO_PI * r[:, d.other] / 0.2 + d.phase))
    )
    return sensor_answer(d, "other_axis", [f"range_{AXES[d.other]}"])


def stripes(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A sensor's error repeats every few centimetres of its own distance."""
    d = drawn_at(rng, 0.003, 0.006, strength)
    length = float(rng.uniform(0.05, 0.1))
    machine.sensors.quirks.append(
        at_sensor(d.index, lambda t, r, v: d.size * np.sin(TWO_PI * r[:, d.index] / length))
    )
    return sensor_answer(d, "stripes", [f"range_{AXES[d.index]}"])


def fast_reading(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A sensor reads long while its target moves, whichever way."""
    d = drawn_at(rng, 0.004, 0.008, strength)
    machine.sensors.quirks.append(
        at_sensor(d.index, lambda t, r, v: d.size * np.tanh(np.abs(v[:, d.index]) / 0.02))
    )
    return sensor_answer(
        d, "fast_reading", [f"speed_{AXES[d.index]}", f"speed_range_{AXES[d.index]}"]
    )


def slow_sensor(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """One sensor alone smooths over its past."""
    d = drawn_at(rng, 0.06, 0.12, strength)
    machine.sensors.own_lag_s[d.index] = d.size
    own = AXES[d.index]
    return sensor_answer(d, "slow_sensor", [f"speed_{own}", f"speed_range_{own}"], True, "s")


def wobble(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A sensor wanders up and down over a minute or two, like with the temperature of a room."""
    d = drawn_at(rng, 0.003, 0.006, strength)
    period_s = float(rng.uniform(30.0, 70.0))
    machine.sensors.quirks.append(
        at_sensor(d.index, lambda t, r, v: d.size * np.sin(TWO_PI * t / period_s + d.phase))
    )
    return sensor_answer(d, "wobble", ["time"])


def bent_joint(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """An arm's angle errs with the square of its angle."""
    d = drawn_at(rng, 0.008, 0.016, strength)
    machine.robot.joints.bends.append(
        at_joint(d.index, lambda q, t: d.size * ((q[:, d.index] - 0.65) / 0.65) ** 2)
    )
    return motor_answer(d, "bent_joint", [f"theta_{d.index + 1}"])


def dented_tooth(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A bump in an arm's angle at one place of its gear (or a magnetised spot of its encoder)."""
    d = drawn_at(rng, 0.010, 0.020, strength)
    place = float(rng.uniform(0.4, 0.9))
    machine.robot.joints.bends.append(
        at_joint(d.index, lambda q, t: d.size * np.exp(-(((q[:, d.index] - place) / 0.1) ** 2)))
    )
    return motor_answer(d, "dented_tooth", [f"theta_{d.index + 1}"])


def slip_with_speed(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """An arm is lower while its motor turns, whichever way."""
    d = drawn_at(rng, 0.006, 0.012, strength)

    def slip(q: FloatArray, t_s: FloatArray) -> FloatArray:
        speed = uniform_filter1d(np.gradient(q[:, d.index], t_s), 40, mode="nearest")
        slipped: FloatArray = d.size * np.tanh(np.abs(speed) / 0.05)
        return slipped

    machine.robot.joints.bends.append(at_joint(d.index, slip))
    return motor_answer(d, "slip_with_speed", [f"speed_{d.index + 1}"])


def coupled_joints(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """An arm is pulled along by its neighbour, by a cable or a bent plate."""
    d = drawn_at(rng, 0.006, 0.012, strength)
    machine.robot.joints.bends.append(
        at_joint(d.index, lambda q, t: d.size * np.sin(4.0 * q[:, d.other] + d.phase))
    )
    return motor_answer(d, "coupled_joints", [f"theta_{d.other + 1}"])


def play_with_angle(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """Play that is wide at some angles and gone at others, in a bearing that sticks."""
    d = drawn_at(rng, 0.012, 0.018, strength)
    joints = machine.robot.joints
    joints.friction_nm[d.index] = 2.5

    def width(q: FloatArray, t_s: FloatArray) -> FloatArray:
        played = np.zeros_like(q)
        played[:, d.index] = d.size * np.sin(1.2 * q[:, d.index]) ** 4
        return played

    joints.play_shape = width
    return motor_answer(d, "play_with_angle", [f"theta_{d.index + 1}"], memory=True)


def ratchet(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """A coupling creeps a little with every lowering of the arm and never comes back."""
    d = drawn_at(rng, 0.010, 0.020, strength)

    def creep(q: FloatArray, t_s: FloatArray) -> FloatArray:
        down = np.maximum(np.diff(q[:, d.index], prepend=q[0, d.index]), 0.0)
        # The size is what has gathered at the end of the run.
        gathered: FloatArray = d.size * np.cumsum(down) / max(float(down.sum()), 1e-9)
        return gathered

    machine.robot.joints.bends.append(at_joint(d.index, creep))
    return motor_answer(
        d, "ratchet", ["time", f"theta_{d.index + 1}", f"speed_{d.index + 1}"], True
    )


def sway(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """The platform's target sways to and fro in one level direction, like a table that is hit."""
    d = drawn_at(rng, 0.004, 0.007, strength)
    rate_hz, way = float(rng.uniform(0.1, 0.5)), float(rng.uniform(0.0, TWO_PI))
    direction = np.array([np.cos(way), np.sin(way), 0.0])

    def quirk(t_s: FloatArray, ranges: FloatArray, speed: FloatArray) -> FloatArray:
        return d.size * np.outer(np.sin(TWO_PI * rate_hz * t_s + d.phase), direction)

    machine.sensors.quirks.append(quirk)
    made = unknown("sway", "platform", d.size, "m")
    return replace(made, also_where=("frame", "range_x", "range_y"), depends_on=("time",))


def bowl(machine: Machine, rng: np.random.Generator, strength: float) -> Hidden:
    """The platform's plate is warped: its height errs with the distance from the middle."""
    d = drawn_at(rng, 0.003, 0.006, strength)

    def quirk(t_s: FloatArray, ranges: FloatArray, speed: FloatArray) -> FloatArray:
        added = np.zeros_like(ranges)
        from_middle = np.hypot(ranges[:, 0] - 0.6, ranges[:, 1] - 0.6)
        added[:, 2] = d.size * (from_middle / 0.12) ** 2
        return added

    machine.sensors.quirks.append(quirk)
    made = unknown("bowl", "platform", d.size, "m")
    return replace(made, also_where=("frame", "range_z"), depends_on=("range_x", "range_y"))


ODDITIES: dict[str, Build] = {
    build.__name__: build
    for build in (
        *(other_axis, stripes, fast_reading, slow_sensor, wobble, bent_joint, dented_tooth),
        *(slip_with_speed, coupled_joints, play_with_angle, ratchet, sway, bowl),
    )
}
