"""Micro deltas with something hidden, and the motions at random that shall show it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from deltactl.proof.micro.as_built import Drives, FloatArray, MicroDelta, Three

JOINTS = ("motor1", "motor2", "motor3")
MIDDLE_RAD = np.radians(33.0)
WAVES = 4
SLOWEST_HZ, FASTEST_HZ = 0.1, 1.2
SMALLEST_RAD, LARGEST_RAD = np.radians(2.0), np.radians(9.0)
"""Sizes of one wave: up to 36 degrees of arm either way, and 3 rad/s at the very most."""


@dataclass(frozen=True, slots=True)
class Hidden:
    """One hidden cause: its name and place in the vocabulary, its size, and the robot."""

    effect: str
    component: str
    size: float
    robot: MicroDelta


def _at(values: Three, joint: int, value: float) -> Three:
    first, second, third = (value if n == joint else old for n, old in enumerate(values))
    return first, second, third


def _friction(rng: np.random.Generator, joint: int) -> Hidden:
    drives = Drives()
    more = float(drives.dry_nm()[joint] * np.exp(rng.uniform(np.log(0.3), np.log(1.5))))
    rub = _at(drives.bearing_coulomb_nm, joint, drives.bearing_coulomb_nm[joint] + more)
    robot = MicroDelta(drives=replace(drives, bearing_coulomb_nm=rub))
    return Hidden("joint_friction", JOINTS[joint], more, robot)


def _viscous(rng: np.random.Generator, joint: int) -> Hidden:
    drives = Drives()
    more = float(np.exp(rng.uniform(np.log(5e-5), np.log(5e-4))))
    drag = _at(drives.bearing_viscous_nmsprad, joint, drives.bearing_viscous_nmsprad[joint] + more)
    robot = MicroDelta(drives=replace(drives, bearing_viscous_nmsprad=drag))
    return Hidden("viscous_friction", JOINTS[joint], more, robot)


def _gravity(rng: np.random.Generator, joint: int) -> Hidden:
    torque = float(rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(np.log(3e-4), np.log(2e-3))))
    plain = MicroDelta()
    body = replace(plain.body, counterweight_nm=_at(plain.body.counterweight_nm, joint, torque))
    return Hidden("gravity_error", JOINTS[joint], torque, MicroDelta(body))


def _payload(rng: np.random.Generator, joint: int) -> Hidden:
    mass = float(np.exp(rng.uniform(np.log(5e-4), np.log(4e-3))))
    return Hidden(
        "payload", "platform", mass, MicroDelta(replace(MicroDelta().body, payload_kg=mass))
    )


def _gain(rng: np.random.Generator, joint: int) -> Hidden:
    scale = float(1.0 + rng.choice([-1.0, 1.0]) * np.exp(rng.uniform(np.log(0.03), np.log(0.15))))
    drives = Drives()
    constants = _at(drives.torque_constant_nmpa, joint, scale * drives.torque_constant_nmpa[joint])
    robot = MicroDelta(drives=replace(drives, torque_constant_nmpa=constants))
    return Hidden("effort_gain", JOINTS[joint], scale, robot)


def _nothing(rng: np.random.Generator, joint: int) -> Hidden:
    return Hidden("nothing", "", 0.0, MicroDelta())


KINDS: tuple[Callable[[np.random.Generator, int], Hidden], ...] = (
    _nothing,
    _friction,
    _viscous,
    _gravity,
    _payload,
    _gain,
)
"""Sizes are drawn evenly in their logarithm, from small (a few per cent of what the joint bears)
to what anybody would see."""


def case(seed: int, number: int) -> tuple[Hidden, np.random.Generator]:
    """Case `number` of a seed, and what draws its motions. Kinds and joints take turns."""
    rng = np.random.default_rng([seed, number])
    return KINDS[number % len(KINDS)](rng, number // len(KINDS) % len(JOINTS)), rng


def random_motion(rng: np.random.Generator, t_s: FloatArray) -> FloatArray:
    """Arm references (n, 3): a few waves a joint, each with its own pace."""
    angles = np.full((len(t_s), 3), MIDDLE_RAD)
    for joint in range(3):
        for _ in range(WAVES):
            turn = 2.0 * np.pi * rng.uniform(SLOWEST_HZ, FASTEST_HZ) * t_s
            size = rng.uniform(SMALLEST_RAD, LARGEST_RAD)
            angles[:, joint] += size * np.sin(turn + rng.uniform(0.0, 2.0 * np.pi))
    return angles
