"""Arms and gantries in motion whose drives have faults, by a simulator that shares no code with the
models: Pinocchio does the rigid bodies, this file the motions, joints, drives and encoders.

A joint's friction is the LuGre law (Canudas de Wit, Olsson, Åström and Lischinsky 1995, IEEE
Transactions on Automatic Control 40, 419-425), which yields before it slides. On half of the
machines a part of it grows with the load of the gear, by 0.06 to 0.15 N m for each N m where it was
measured (`joint_friction.OF_LOAD`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
Rng = np.random.Generator
FINE_S = 1e-3
"""Step at which motions and drives are simulated."""
MARGIN_S = 0.5
"""Simulated beyond both ends, as an effort may be read early."""
ARM = ("pan", "shoulder", "elbow", "roll", "pitch", "flange")
ARM_AXES = np.array([[0, 0, 1], [0, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0]])
ARM_TURNS = (0.0, 0.0, 0.0, 0.5 * np.pi, -0.5 * np.pi, 0.0)
"""About y before each joint: the roll joint turns about its own z."""
GANTRY = ("bridge", "cart", "lift")
DRAWN_MASS = 0.005
"""Share by which the masses of a machine are off its drawing, where `Faults` says no more."""
YIELDS = (3e-5, 1e-3)
"""Way before a bearing slides, as a share of the reach: up to three minutes of arc."""
BY_LOAD = 0.1
"""Largest friction of a gear for each unit of its load,"""
MOST_BY_LOAD = 0.6
"""and the largest share of its friction that grows so. A size of friction is that at the usual
load."""

SLOW = 0.01
"""Share of the top speed that is a rest."""


@dataclass(frozen=True, eq=False)
class Machine:
    """What its drawing says; lengths [m], masses [kg], friction of its joints [N m or N]."""

    slides: bool
    joints: tuple[str, ...]
    axes: FloatArray
    origins: FloatArray
    turns: FloatArray
    masses: FloatArray
    centres: FloatArray
    reaches: FloatArray
    """Largest way to each side [rad or m]."""
    dry: FloatArray
    viscous: FloatArray

    @property
    def tip(self) -> str:
        """The link that carries a load."""
        return f"link_{self.joints[-1]}"

    def urdf(self) -> str:
        """The drawing. A URDF has no place for a rotor."""
        parts = ['<robot name="drawn"><link name="base"/>']
        kind = "prismatic" if self.slides else "revolute"
        for j, name in enumerate(self.joints):
            above = "base" if j == 0 else f"link_{self.joints[j - 1]}"
            rows = (self.origins, self.axes, self.centres)
            origin, axis, centre = (" ".join(f"{x:.6g}" for x in one[j]) for one in rows)
            xx, yy, zz = self.masses[j] * (0.03**2 + np.sum(self.centres[j] ** 2) / 6.0) * _ROUND
            parts.append(
                f'<joint name="{name}" type="{kind}"><parent link="{above}"/>'
                f'<child link="link_{name}"/><origin xyz="{origin}" rpy="0 {self.turns[j]:.9g} 0"/>'
                f'<axis xyz="{axis}"/><limit lower="-7" upper="7" effort="999" velocity="99"/>'
                f'<dynamics friction="{self.dry[j]:.9g}" damping="{self.viscous[j]:.9g}"/></joint>'
                f'<link name="link_{name}"><inertial><origin xyz="{centre}"/>'
                f'<mass value="{self.masses[j]:.9g}"/><inertia ixx="{xx:.9g}" iyy="{yy:.9g}"'
                f' izz="{zz:.9g}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            )
        return "".join([*parts, "</robot>"])


_ROUND = np.array([1.0, 1.3, 0.8])


def machine(rng: Rng, gantry: bool) -> Machine:
    """A machine of a drawn size; half of the drawings state friction."""
    size = float(np.exp(rng.uniform(np.log(0.6), np.log(1.5))))
    if gantry:
        joints: tuple[str, ...] = GANTRY
        axes, turns = np.eye(3), np.zeros(3)
        origins = size * np.array([[0, 0, 1.0], [0, 0.1, 0.05], [0.05, 0, -0.1]])
        masses = size**2 * np.array([18.0, 7.0, 4.0]) * rng.uniform(0.7, 1.4, 3)
        centres = size * rng.uniform(-0.1, 0.1, (3, 3))
        reaches = size * np.array([0.6, 0.4, 0.2])
        usual = 9.81 * masses[2] * np.ones(3)
    else:
        joints, axes, turns = ARM, ARM_AXES.astype(float), np.array(ARM_TURNS)
        origins = size * np.array(
            [[0, 0, 0.2], [0.1, 0.05, 0.15], [0, 0, 0.5], [0.1, 0, 0.08], [0, 0, 0.35], [0.1, 0, 0]]
        )
        masses = size**2 * np.array([10.0, 11.0, 6.0, 3.0, 1.8, 0.7]) * rng.uniform(0.7, 1.4, 6)
        x, y = [0.03, 0, 0.07, 0, 0.05, 0.05], [0, 0.05, 0, 0, 0, 0.01]
        z = [0.08, 0.22, 0.03, 0.15, 0.01, 0.02]
        centres = size * np.column_stack([x, y, z])
        reaches = np.array([2.0, 1.0, 1.2, 2.2, 1.6, 2.5])
        usual = 9.81 * size * np.array([5.0, 5.0, 2.5, 0.4, 0.25, 0.08]) * size**2
    stated = 0.15 * usual * rng.integers(0, 2)
    dry = stated * rng.uniform(0.5, 1.5, len(joints))
    viscous = stated * rng.uniform(0.3, 1.0, len(joints))
    return Machine(gantry, joints, axes, origins, turns, masses, centres, reaches, dry, viscous)


@dataclass
class Faults:
    """What a machine has beyond its drawing, one of each joint; nothing by default."""

    joints: int
    load_kg: float = 0.0
    load_at_m: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        """Each an array (joints,)."""
        none = np.zeros(self.joints)
        self.dry, self.viscous, self.rotor, self.offset = (none.copy() for _ in range(4))
        self.dead_s, self.drift, self.by_place = (none.copy() for _ in range(3))
        self.one_way = none.copy()
        """Dry friction that is more forward than `dry`, and less backward."""
        self.ripple, self.waves = none.copy(), none + 1.0
        """Effort that repeats with the angle of the joint, and how often a turn or metre."""
        self.sticks = none.copy()
        """Friction near standstill beyond that where it slides,"""
        self.sticks_to = none + 1.0
        """and the speed within which it falls off."""
        self.lag_s = none.copy()
        """Time constant behind which a drive gives its effort."""
        self.gain = none + 1.0
        self.mass = none + DRAWN_MASS
        """Usual share by which a link's mass is off the drawing."""
        self.clocks = none.copy()
        """Quarters of a sampling period by which an effort is read early."""
        self.coupled = np.zeros((self.joints, self.joints))
        """Share of another joint's effort that a joint's column has too."""


@dataclass(frozen=True, eq=False)
class Moved:
    """A motion on the fine grid: times (m,), positions, velocities, accelerations (m, joints)."""

    t_s: FloatArray
    at: FloatArray
    speed: FloatArray
    change: FloatArray


def fourier(rng: Rng, own: Machine, seconds: float) -> Moved:
    """Sums of five harmonics."""
    t_s = np.arange(-MARGIN_S, seconds + MARGIN_S, FINE_S)
    shape = (len(t_s), len(own.joints))
    at, speed, change = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    first = 2.0 * np.pi * rng.uniform(0.05, 0.12)
    for k in range(1, 6):
        w = first * k
        for j, reach in enumerate(own.reaches):
            size, phase = reach * rng.uniform(0.2, 0.6) / k, rng.uniform(0.0, 2.0 * np.pi)
            at[:, j] += size * np.sin(w * t_s + phase)
            speed[:, j] += size * w * np.cos(w * t_s + phase)
            change[:, j] -= size * w * w * np.sin(w * t_s + phase)
    return Moved(t_s, at, speed, change)


def trapezoids(rng: Rng, own: Machine, seconds: float) -> Moved:
    """Moves of all joints between places, speeding up evenly, with rests between them."""
    t_s = np.arange(-MARGIN_S, seconds + MARGIN_S, FINE_S)
    change = np.zeros((len(t_s), len(own.joints)))
    at = place = own.reaches * rng.uniform(-0.7, 0.7, len(own.joints))
    row = int(1.5 * MARGIN_S / FINE_S)
    while True:
        move_s, ramp, rest_s = rng.uniform(0.8, 2.5), rng.uniform(0.15, 0.4), rng.uniform(0.2, 0.8)
        steps, up = int(move_s / FINE_S), int(ramp * move_s / FINE_S)
        if row + steps + int(MARGIN_S / FINE_S) >= len(t_s):
            break
        target = own.reaches * rng.uniform(-1.0, 1.0, len(own.joints))
        rise = (target - place) / (up * (steps - up) * FINE_S**2)
        change[row : row + up] += rise
        change[row + steps - up : row + steps] -= rise
        place, row = target, row + steps + int(rest_s / FINE_S)
    soft = np.hanning(int(rng.uniform(0.03, 0.08) / FINE_S))
    change = np.stack([np.convolve(c, soft / soft.sum(), "same") for c in change.T], axis=1)
    gained = np.cumsum(change, axis=0) * FINE_S  # at the middle of the steps
    moved = (np.cumsum(gained, axis=0) - gained) * FINE_S
    return Moved(t_s, at + moved, gained - 0.5 * FINE_S * change, change)


def rigid(own: Machine, moved: Moved, faults: Faults, off: FloatArray) -> FloatArray:
    """Efforts (m, joints) of the links alone; off: share by which masses are off the drawing."""
    import pinocchio as pin

    model: Any = pin.buildModelFromXML(own.urdf())
    data = model.createData()
    for j in range(len(own.joints)):
        model.inertias[j + 1] = _heavier(pin, model.inertias[j + 1], 1.0 + float(off[j]))
    if faults.load_kg:
        size = np.diag([0.4, 0.3, 0.5]) * faults.load_kg * 0.05**2
        model.appendBodyToJoint(
            len(own.joints), pin.Inertia(faults.load_kg, faults.load_at_m, size), pin.SE3.Identity()
        )
        data = model.createData()
    rows = zip(moved.at, moved.speed, moved.change, strict=True)
    return np.array([pin.rnea(model, data, q, v, a) for q, v, a in rows])


def _heavier(pin: Any, inertia: Any, times: float) -> Any:
    return pin.Inertia(times * inertia.mass, inertia.lever, times * inertia.inertia)


def lugre(moved: Moved, dry: FloatArray, yields: FloatArray) -> FloatArray:
    """Dry friction (m, joints); dry: where it slides; yields: way before it does."""
    z, made = np.zeros(moved.at.shape[1]), np.empty_like(moved.at)
    stiff = np.max(dry, axis=0) / yields
    for row, speed in enumerate(moved.speed):
        held = stiff * FINE_S * np.abs(speed) / np.maximum(dry[row], 1e-12)
        z = (z + FINE_S * speed) / (1.0 + held)
        made[row] = stiff * z
    return np.asarray(made)


def _dry(own: Machine, faults: Faults, moved: Moved, load: FloatArray, rng: Rng) -> FloatArray:
    """Dry friction (m, joints) where bearings slide; the usual load is that in motion."""
    slides = np.abs(moved.speed) > SLOW * np.max(np.abs(moved.speed), axis=0)
    usual = np.mean(np.abs(load), axis=0, where=slides)
    place = moved.at / own.reaches
    by_load = rng.integers(0, 2) * rng.uniform(0.0, BY_LOAD, len(usual))
    by_load = np.minimum(by_load, MOST_BY_LOAD * (own.dry + faults.dry) / usual)
    grows = by_load * (np.abs(load) - usual)
    dry = own.dry + faults.dry * (1.0 + faults.by_place * place) + grows
    dry = dry + faults.one_way * np.sign(moved.speed)
    dry = dry + faults.sticks * np.exp(-((moved.speed / faults.sticks_to) ** 2))
    return np.asarray(np.maximum(dry, 0.0))


def efforts(own: Machine, moved: Moved, faults: Faults, rng: Rng) -> FloatArray:
    """Columns of effort (m, joints) on the fine grid, without noise."""
    links = rigid(own, moved, faults, faults.mass * rng.standard_normal(len(own.joints)))
    dry = _dry(own, faults, moved, links, rng)
    yields = own.reaches * np.exp(
        rng.uniform(np.log(YIELDS[0]), np.log(YIELDS[1]), len(own.joints))
    )
    drive = links + faults.rotor * moved.change + faults.offset + lugre(moved, dry, yields)
    drive += (own.viscous + faults.viscous) * moved.speed
    turn = 1.0 if own.slides else 2.0 * np.pi
    drive += faults.ripple * np.sin(2.0 * np.pi / turn * faults.waves * moved.at + 1.0)
    drive += drive @ faults.coupled.T
    aged = 1.0 + faults.drift * (moved.t_s / moved.t_s[-1])[:, None]
    drive = drive / faults.gain / aged
    drive += faults.lag_s * np.gradient(drive, FINE_S, axis=0)
    pairs = zip(faults.dead_s, drive.T, strict=True)
    asked = [np.interp(moved.t_s + dead_s, moved.t_s, one) for dead_s, one in pairs]
    return np.stack(asked, axis=1)


def recorded(
    file: Path,
    own: Machine,
    faults: Faults,
    rng: Rng,
    moved: Moved,
    seconds: float,
    counts: int = 0,
) -> None:
    """Write the table: positions as counts of an encoder, noise of the current with a memory.

    counts: in the reach to one side; drawn where 0.
    """
    rate_hz = float(rng.choice([100.0, 125.0, 200.0]))
    faults.dead_s = faults.dead_s + 0.25 / rate_hz * faults.clocks
    drive = efforts(own, moved, faults, rng)
    t_s = np.arange(0.0, seconds, 1.0 / rate_hz)

    def sampled(values: FloatArray) -> FloatArray:
        return np.stack([np.interp(t_s, moved.t_s, one) for one in values.T], axis=1)

    count = own.reaches * 2.0 ** -rng.integers(16, 20)
    count = own.reaches / counts if counts else count
    at = count * np.round(sampled(moved.at) / count)
    effort = sampled(drive)
    share = rng.uniform(0.01, 0.03) * np.sqrt(np.mean(effort**2, axis=0))
    keeps = np.exp(-1.0 / (rate_hz * rng.uniform(0.005, 0.02)))
    effort += share * _coloured(rng, effort.shape, float(keeps))
    columns, names = [t_s, *at.T], ["t"]
    numbers = range(1, len(own.joints) + 1)
    names += [f"theta_{n}" for n in numbers]
    if rng.integers(0, 2):
        speed = sampled(moved.speed)
        speed += 1e-3 * np.std(speed, axis=0) * rng.standard_normal(speed.shape)
        columns += [*speed.T]
        names += [f"velocity_{n}" for n in numbers]
    columns, names = [*columns, *effort.T], [*names, *(f"effort_{n}" for n in numbers)]
    np.savetxt(file, np.column_stack(columns), "%.9g", ",", header=",".join(names), comments="")


def _coloured(rng: Rng, shape: tuple[int, ...], keeps: float) -> FloatArray:
    """Noise (n, joints) of variance 1 of which each value keeps a share of the one before."""
    fresh = np.sqrt(1.0 - keeps**2) * rng.standard_normal(shape)
    made, last = np.empty(shape), rng.standard_normal(shape[1])
    for row, new in enumerate(fresh):
        made[row] = last = keeps * last + new
    return made
