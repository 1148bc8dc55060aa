"""What is drawn for arms and gantries in motion: the machine, its motion and its faults.

Needs Pinocchio, numpy and nothing of deltactl: another environment can draw them too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.proofs.moving_machines import (
    Faults,
    FloatArray,
    Machine,
    Moved,
    fourier,
    machine,
    recorded,
    rigid,
    trapezoids,
)

Rng = np.random.Generator
Fault = tuple[str, str, float]
"""What it is called among the regressors of a chain, "load", or which size of a lag ("time",
"dead_time") it is; joint or link, size."""

SECONDS = 60.0
TIERS = ("none", "single", "pair", "unknown")
WAVES = (3.0, 30.0)
"""Over the travel, of an effort that repeats with the angle."""
BEYOND_STATED = 0.2
"""Share of the stated friction by which a fault's is larger: by half as much two days differ."""
OFF = {"mass": 0.02, "gain": 0.02, "dry": 0.05, "viscous": 0.05, "offset": 0.01}
"""Usual shares by which a machine as built is off its drawing: what the diagnosis tolerates."""
MOST_OFF = 2.0
"""Times these, beyond which it is a fault."""
OF_FOUR = (0, 1, 1, 1, 2, 2, 2, 3)
"""Tiers in turn: one healthy machine in eight, three with one fault, three with two."""


class Draw:
    """What is drawn for one machine: how large a fault usually is at each joint."""

    def __init__(self, rng: Rng, own: Machine, moved: Moved):
        self.rng, self.own, self.moved = rng, own, moved
        self.faults = Faults(len(own.joints))
        bare = rigid(own, _every(moved, 50), self.faults, np.zeros(len(own.joints)))
        needed = bare + np.sign(_every(moved, 50).speed) * own.dry
        self.effort: FloatArray = np.sqrt(np.mean(needed**2, axis=0))
        """Effort of each joint, root mean square."""
        self.expected: list[Fault] = []

    def joint(self) -> int:
        """Any."""
        return int(self.rng.integers(len(self.own.joints)))

    def share(self, low: float = 0.06, high: float = 0.4) -> float:
        """Share of the usual effort."""
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def beside(self, stated: float, size: float) -> float:
        """A size beyond that by which friction differs from what the drawing states."""
        return max(size, BEYOND_STATED * stated)

    def expects(self, key: str, joint: int, size: float) -> None:
        """One fault at a joint."""
        self.expected.append((key, self.own.joints[joint], float(size)))


def _every(moved: Moved, rows: int) -> Moved:
    each = (moved.t_s, moved.at, moved.speed, moved.change)
    return Moved(*(values[::rows] for values in each))


def _dry(draw: Draw) -> None:
    j = draw.joint()
    draw.faults.dry[j] = draw.beside(draw.own.dry[j], draw.share() * draw.effort[j])
    draw.expects("dry", j, draw.faults.dry[j])


def _viscous(draw: Draw) -> None:
    j = draw.joint()
    top = np.quantile(np.abs(draw.moved.speed[:, j]), 0.95)
    size = 1.5 * draw.share() * draw.effort[j] / top
    draw.faults.viscous[j] = draw.beside(draw.own.viscous[j], size)
    draw.expects("viscous", j, draw.faults.viscous[j])


def _rotor(draw: Draw) -> None:
    j = draw.joint()
    while draw.own.slides and draw.faults.gain[j] != 1.0:
        j = draw.joint()
    draw.faults.rotor[j] = draw.share() * draw.effort[j] / np.std(draw.moved.change[:, j])
    draw.expects("rotor", j, draw.faults.rotor[j])


def _offset(draw: Draw) -> None:
    j = draw.joint()
    draw.faults.offset[j] = draw.rng.choice([-1.0, 1.0]) * draw.share() * draw.effort[j]
    draw.expects("offset", j, draw.faults.offset[j])


def _gain(draw: Draw) -> None:
    j = draw.joint()
    while draw.own.slides and draw.faults.rotor[j]:  # on a level slide both are one
        j = draw.joint()
    draw.faults.gain[j] = np.exp(draw.rng.choice([-1.0, 1.0]) * draw.rng.uniform(0.1, 0.25))
    draw.expects("gain", j, draw.faults.gain[j])


def _lag(draw: Draw) -> None:
    j = draw.joint()
    draw.faults.dead_s[j] = np.exp(draw.rng.uniform(np.log(0.008), np.log(0.06)))
    draw.expects("dead_time", j, draw.faults.dead_s[j])


def _load(draw: Draw) -> None:
    own, faults = draw.own, draw.faults
    faults.load_kg = draw.share(0.03, 0.15) * float(own.masses.sum())
    faults.load_at_m = draw.rng.uniform(-0.1, 0.1, 3)
    draw.expected.append(("load", own.tip, faults.load_kg))


def _stribeck(draw: Draw) -> None:
    j = draw.joint()
    top = np.quantile(np.abs(draw.moved.speed[:, j]), 0.95)
    draw.faults.sticks[j] = draw.share(0.15, 0.6) * draw.effort[j]
    draw.faults.dry[j] = draw.beside(draw.own.dry[j], draw.share(0.15, 0.4) * draw.effort[j])
    draw.faults.sticks_to[j] = draw.share(0.1, 0.4) * top
    draw.expects("stribeck", j, draw.faults.sticks[j])
    draw.expects("dry", j, draw.faults.dry[j])


def _first_order(draw: Draw) -> None:
    j = draw.joint()
    draw.faults.lag_s[j] = np.exp(draw.rng.uniform(np.log(0.008), np.log(0.06)))
    draw.expects("time", j, draw.faults.lag_s[j])


def _one_way(draw: Draw) -> None:
    j = draw.joint()
    draw.faults.dry[j] = draw.beside(draw.own.dry[j], draw.share(0.15, 0.4) * draw.effort[j])
    share = draw.rng.choice([-1.0, 1.0]) * draw.rng.uniform(0.2, 0.6)
    draw.faults.one_way[j] = share * draw.faults.dry[j]
    draw.expects("dry", j, draw.faults.dry[j])
    draw.expects("offset", j, draw.faults.one_way[j])


NAMED: tuple[Callable[[Draw], None], ...] = (_dry, _viscous, _rotor, _offset, _gain, _lag, _load)


def _coupled(draw: Draw) -> int:
    """One joint's drive turns another joint too."""
    j = draw.joint()
    other = (j + 1) % len(draw.own.joints)
    draw.faults.coupled[j, other] = draw.share(0.15, 0.4) * draw.effort[j] / draw.effort[other]
    return j


def _drifts(draw: Draw) -> int:
    """A torque constant that changes as a motor warms up."""
    j = draw.joint()
    draw.faults.drift[j] = -draw.share(0.1, 0.35)
    return j


def _by_place(draw: Draw) -> int:
    """Friction that grows along the way."""
    j = draw.joint()
    draw.faults.dry[j] = draw.share(0.15, 0.4) * draw.effort[j]
    draw.faults.by_place[j] = draw.rng.choice([-0.8, 0.8])
    return j


def _ripple(draw: Draw) -> int:
    """A drive whose effort repeats with the angle of its joint."""
    j = draw.joint()
    draw.faults.ripple[j] = draw.share(0.1, 0.4) * draw.effort[j]
    turn = 1.0 if draw.own.slides else 2.0 * np.pi
    draw.faults.waves[j] = draw.rng.uniform(*WAVES) * turn / (2.0 * draw.own.reaches[j])
    return j


ALONE: dict[str, Callable[[Draw], int | None]] = {
    "dead_time": _lag,
    "first_order_lag": _first_order,
    "friction_by_direction": _one_way,
    "ripple": _ripple,
    "stribeck": _stribeck,
}
"""Faults that are only drawn where they are asked for, so that the other draws stay as they are."""
UNKNOWN: tuple[Callable[[Draw], int], ...] = (_coupled, _drifts, _by_place)


def _as_built(draw: Draw, rng: Rng) -> None:
    """Tolerances of a machine, of all that is no fault of it."""
    own, faults, shape = draw.own, draw.faults, (5, len(draw.own.joints))
    off = np.clip(rng.standard_normal(shape), -MOST_OFF, MOST_OFF)
    hidden = {(key, joint) for key, joint, _ in draw.expected}
    tolerances = {
        "dry": own.dry,
        "viscous": own.viscous,
        "offset": draw.effort,
        "gain": np.ones(len(own.joints)),
    }
    for (key, size), drawn_off in zip(tolerances.items(), off, strict=False):
        free = [(key, joint) not in hidden for joint in own.joints]
        getattr(faults, key)[:] += OFF[key] * size * drawn_off * free
    faults.mass[:] = OFF["mass"]
    faults.clocks[:] = off[4]


@dataclass(frozen=True, slots=True)
class Kind:
    """Which machines are drawn.

    fault: what of `ALONE` each hides instead of its own. as_built: with all tolerances that the
    diagnosis allows for, and not only with masses. counts: see `recorded`.
    """

    fault: str = ""
    as_built: bool = False
    counts: int = 0


USUAL = Kind()


def tier_of(number: int) -> str:
    """What machine `number` of any seed hides."""
    return TIERS[OF_FOUR[number % len(OF_FOUR)]]


def drawn(
    seed: int,
    number: int,
    gantry: bool,
    file: Path,
    seconds: float = SECONDS,
    kind: Kind = USUAL,
) -> tuple[str, Draw, str]:
    """Machine `number` of a seed: its tier and faults, and the joint of what has no name.

    Writes its recording, and beside it its URDF.
    """
    rng = np.random.default_rng([seed, number, int(gantry)])
    own = machine(rng, gantry)
    moved = (fourier if rng.integers(0, 2) else trapezoids)(rng, own, seconds)
    draw, tier, joint = Draw(rng, own, moved), tier_of(number), ""
    if kind.fault:
        tier, unnamed = kind.fault, ALONE[kind.fault](draw)
        joint = "" if unnamed is None else own.joints[unnamed]
    elif tier == "unknown":
        joint = own.joints[UNKNOWN[number // len(OF_FOUR) % len(UNKNOWN)](draw)]
    else:
        for which in rng.choice(len(NAMED), TIERS.index(tier), replace=False):
            NAMED[int(which)](draw)
    if kind.as_built:
        _as_built(draw, np.random.default_rng([seed, number, int(gantry), 1]))
    file.with_suffix(".urdf").write_text(own.urdf())
    recorded(file, own, draw.faults, rng, moved, seconds, kind.counts)
    return tier, draw, joint
