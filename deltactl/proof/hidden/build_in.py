"""Build causes into a machine, in the order in which they depend on one another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import mujoco
import numpy as np

from deltactl.proof.hidden import frame, joints, sensing
from deltactl.proof.hidden.hidden import Hidden, Kind, Parameters, number, split_interval
from deltactl.proof.recorded import Machine
from deltactl.proof.robot.as_built import FloatArray
from deltactl.proof.robot.assemble import Assembly
from deltactl.proof.robot.bodies import build
from deltactl.proof.robot.stepping import StepTrain

VOCABULARY: dict[str, Kind] = {
    kind.effect: kind for kind in (*joints.KINDS, *frame.KINDS, *sensing.KINDS)
}
TIED = ("viscous_friction",)
"""Kinds no motion of positions alone can name: a lag of c / k is a lag."""
SINGLES = tuple(name for name in VOCABULARY if name not in TIED)
LOOKS = 400


@dataclass
class Planned:
    """A kind with the component and the sizes that were drawn for it."""

    kind: Kind
    index: int
    parameters: Parameters

    @property
    def component(self) -> str:
        return self.kind.components[self.index]


def plan(kind: Kind, rng: np.random.Generator, strength: float) -> Planned:
    """Draw a component and sizes."""
    return Planned(kind, int(rng.integers(len(kind.components))), kind.draw(rng, strength))


def settle(planned: list[Planned], rng: np.random.Generator, train: StepTrain) -> None:
    """Fill in what depends on the motion: moments of events, the height of a table."""
    for part in planned:
        if part.kind.event:
            part.parameters["time"] = split_interval(rng, train.seconds)
        if part.kind.effect == "contact":
            low = float(np.quantile(heights_m(train), 0.01))
            part.parameters["height"] = low + number(part.parameters["depth"])


def construct(machine: Machine, planned: list[Planned], with_events: bool) -> None:
    """Build everything in; the holdout run has none of the events."""
    for part in sorted(planned, key=lambda part: part.kind.order):
        if with_events or not part.kind.event:
            part.kind.apply(machine, part.index, part.parameters)


def hidden(part: Planned) -> Hidden:
    """The answer to write down."""
    kind = part.kind
    when = number(part.parameters["time"]) if kind.event else None
    return Hidden(
        kind.effect, part.component, part.parameters, kind.main, kind.units[kind.main], when,
        known_size=tuple(name for name in kind.units if name in part.parameters),
    )  # fmt: skip


def heights_m(train: StepTrain) -> FloatArray:
    """Heights the nominal platform visits, looked at a few hundred times, (n,) [m]."""
    machine = Machine()
    model: mujoco.MjModel = build(machine.robot.body, machine.robot.joints, 0.001)
    assembly = Assembly(model)
    start = int(model.joint("platform").qposadr[0])
    looks = np.linspace(0, len(train.counts) - 1, LOOKS).astype(int)
    # Each from the drawing board: from one look to the next is too far to keep the platform below.
    angles_rad = train.counts[looks] * machine.robot.joints.rad_per_step
    heights = [assembly.at(one)[start + 2] for one in angles_rad]
    return cast(FloatArray, np.array(heights))
