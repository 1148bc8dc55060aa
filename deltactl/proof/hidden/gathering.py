"""Causes in no vocabulary whose state builds up with use: wear, heat, creep, dust."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter

from deltactl.proof.hidden.hidden import Hidden
from deltactl.proof.hidden.oddities import (
    AXES,
    at_joint,
    at_sensor,
    drawn_at,
    motor_answer,
    sensor_answer,
)
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import FloatArray

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
    """A motor warms its mount while it turns and lets it cool while it stands: the arm sinks."""
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
