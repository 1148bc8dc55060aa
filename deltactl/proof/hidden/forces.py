"""Forces on the platform that are in no vocabulary; soft joints let them be seen.

How soft the joints are is a named effect, and right to name beside the force.
"""

from __future__ import annotations

import numpy as np

from deltactl.proof.hidden.hidden import Hidden
from deltactl.proof.hidden.oddities import AXES, TWO_PI
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import FloatArray

SOFT_NM_PER_RAD = (300.0, 500.0)
PLACES = tuple(f"range_{axis}" for axis in AXES)
SPEEDS = tuple(f"speed_{axis}" for axis in AXES) + tuple(f"speed_range_{axis}" for axis in AXES)


def _soften(machine: Machine, rng: np.random.Generator) -> None:
    stiffness = machine.robot.joints.stiffness_nm_per_rad
    np.minimum(stiffness, float(rng.uniform(*SOFT_NM_PER_RAD)), out=stiffness)


def _answer(
    kind: str, size: float, unit: str, depends_on: tuple[str, ...], memory: bool | None = False,
    also_where: tuple[str, ...] = (),
) -> Hidden:  # fmt: skip
    return Hidden(
        "unknown", "platform", {"size": size}, "size", unit,
        also_where=("frame", "joints", *also_where), depends_on=depends_on, memory=memory,
        kind=kind, through=(("joint_compliance", "joints"),),
    )  # fmt: skip


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
