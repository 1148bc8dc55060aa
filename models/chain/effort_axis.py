"""A single axis that is driven by effort, by its inverse dynamic model: effort -> force -> mass.

An axis driven by a force is two integrators: simulated for long, any small force runs away. So the
chain says what is left of the force once believed effects have taken theirs and the motion is
known (IDIM: Gautier 1997; Janot, Gautier and Vandanjon 2013, IEEE Trans. Control Syst. Technol.
21, 428-444).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from deltactl.models.chain.active import at
from deltactl.models.chain.axis import entries_of, gravity_pull
from deltactl.models.effects.effort_flow import BoolArray, EffortFlow
from deltactl.models.effects.flow import Load
from deltactl.models.effects.lone_axis import Motion, effort_effects
from deltactl.models.effects.port import Port
from deltactl.models.robot import FloatArray, ServoAxis


@dataclass(frozen=True, slots=True, eq=False)
class Driven:
    """Effort and measured motion over time; arrays of shape (n,)."""

    t_s: FloatArray
    fresh: BoolArray
    effort: FloatArray
    position: FloatArray
    velocity: FloatArray
    direction: FloatArray
    """Of the motion, -1 to 1: friction changes its sign over as much speed as is hardly known."""
    at_rest: BoolArray
    load: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Force:
    """What acts on the mass (n,) [N m or N], and how much mass there is [kg m2 or kg]."""

    force: FloatArray
    inertia: float


class EffortChain:
    """One axis of a known inertia, effort gain and gravity, with believed effects."""

    def __init__(self, robot: ServoAxis):
        self.robot = robot
        self.kinds = effort_effects(robot.motion)
        self._believed = entries_of(robot.effects, self.kinds)

    def force(self, driven: Driven) -> Force:
        """Force that is left to speed up the mass, and the mass."""
        robot = self.robot
        assert robot.inertia is not None
        column = driven.position[:, None]
        load = driven.load[:, None]
        flow = EffortFlow(
            t_s=driven.t_s,
            fresh=driven.fresh,
            start_s=float(driven.t_s[0]),
            angles_rad=robot.effort_gain * driven.effort[:, None],
            load_of=lambda: Load(load, np.zeros_like(load)),
            position=column,
            velocity=driven.velocity[:, None],
            direction=driven.direction[:, None],
            at_rest=driven.at_rest[:, None],
            inertia=robot.inertia,
        )
        for effect in at(self._believed, Port.MOTOR):
            effect.act(flow)
        flow.angles_rad = flow.angles_rad + gravity_pull(robot.gravity, column) + load
        for port in (Port.GEAR, Port.ARM):
            for effect in at(self._believed, port):
                effect.act(flow)
        return Force(flow.angles_rad[:, 0], flow.inertia)


__all__ = ["Driven", "EffortChain", "Force", "Motion"]
