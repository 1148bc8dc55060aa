"""A single axis that is driven by effort: effort -> force -> motion.

An axis driven by a force is two integrators: simulated for long, any small force runs away. So the
chain predicts as an observer does: the motion that the force makes, pulled towards the measured
position with the time constant TAU (critically damped, both poles at -1/TAU):

    predicted = (2 L - L^2) measured + TAU^2 L^2 force / inertia,   L = 1 / (TAU s + 1)

measured - predicted is then (1 - L)^2 of what the model misses, in the unit of the position. The
same filters act on both sides, so they favour no answer (Gautier, Janot and Vandanjon 2013, IEEE
Trans. Control Syst. Technol. 21, 428-444: inverse dynamics needs the same filter on all signals).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from models.chain.active import Active, at
from models.chain.axis import entries_of, gravity_pull
from models.effects.effort_flow import BoolArray, EffortFlow
from models.effects.flow import Load
from models.effects.lone_axis import Motion, effort_effects
from models.effects.port import Port
from models.effects.recursion import lagged
from models.effects.second_difference import second_difference
from models.robot import AxisGravity, EffectEntry, FloatArray

SETTLED = 7.0
"""After so many time constants nothing is left of how a stretch began (0.7 %)."""


@dataclass(frozen=True, slots=True, eq=False)
class Driven:
    """Effort and measured motion over time; arrays of shape (n,) or (n, 1)."""

    t_s: FloatArray
    fresh: BoolArray
    effort: FloatArray
    position: FloatArray
    velocity: FloatArray
    at_rest: BoolArray
    load: FloatArray


class EffortChain:
    """One axis of a known inertia, effort gain and gravity."""

    def __init__(
        self,
        inertia: float,
        tau_s: float,
        motion: Motion = "rotary",
        effort_gain: float = 1.0,
        gravity: AxisGravity | None = None,
        believed: Sequence[EffectEntry] = (),
    ):
        self.kinds = effort_effects(motion)
        self.inertia, self.tau_s, self.effort_gain = inertia, tau_s, effort_gain
        self.gravity = gravity
        self._believed = tuple(believed)
        entries_of(self._believed, self.kinds)

    def simulate(self, driven: Driven, effects: Iterable[Active] = ()) -> FloatArray:
        """Predicted position, shape (n,)."""
        flow = EffortFlow(
            t_s=driven.t_s,
            fresh=driven.fresh,
            start_s=float(driven.t_s[0]),
            angles_rad=self.effort_gain * driven.effort,
            load_of=lambda: Load(driven.load, np.zeros_like(driven.load)),
            position=driven.position,
            velocity=driven.velocity,
            at_rest=driven.at_rest,
            inertia=self.inertia,
        )
        active = [*entries_of(self._believed, self.kinds), *effects]
        for effect in at(active, Port.MOTOR):
            effect.act(flow)
        flow.angles_rad += gravity_pull(self.gravity, driven.position) + driven.load
        for port in (Port.GEAR, Port.ARM):
            for effect in at(active, port):
                effect.act(flow)
        pushed = self.tau_s**2 * flow.angles_rad / flow.inertia
        # `lagged` joins samples by straight lines; a motion is smooth: see effort_hold.
        smooth = driven.position - second_difference(driven.position, driven.fresh) / 12.0
        once = self._lag(smooth, flow)
        both = self._lag(np.hstack([once, self._lag(pushed, flow)]), flow)
        predicted: FloatArray = 2.0 * once[:, 0] - both[:, 0] + both[:, 1]
        return predicted

    def _lag(self, x: FloatArray, flow: EffortFlow) -> FloatArray:
        return lagged(x, flow.step_s, self.tau_s, {})

    def settled(self, driven: Driven) -> BoolArray:
        """Samples late enough in their stretch, shape (n,)."""
        starts = np.flatnonzero(driven.fresh)
        begin = driven.t_s[starts][np.cumsum(driven.fresh) - 1]
        settled: BoolArray = driven.t_s - begin > SETTLED * self.tau_s
        return settled
