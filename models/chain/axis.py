"""A single axis that follows commands: counts -> motor -> gear -> axis -> encoder."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from deltactl.models.chain.active import Active, activate, at
from deltactl.models.chain.commands import BoolArray, Commands
from deltactl.models.effects.flow import EffortFlow, Flow, Load
from deltactl.models.effects.kind import EffectKind, Port
from deltactl.models.effects.lone_axis import (
    Motion,
    command_effects,
    effort_effects,
    sensor_effects,
)
from deltactl.models.robot import AxisGravity, EffectEntry, FloatArray, ServoAxis

PORTS = (Port.MOTOR, Port.GEAR, Port.ARM)


def entries_of(entries: Sequence[EffectEntry], kinds: dict[str, EffectKind]) -> list[Active]:
    """Effects of a robot file in the vocabulary of its kind. Raises ConfigError on others."""
    from deltactl.foundation.errors import ConfigError

    for entry in entries:
        if entry.effect not in kinds:
            raise ConfigError(f"effect '{entry.effect}' must be one of {', '.join(sorted(kinds))}")
    return [activate(kinds[e.effect], e.component, e.parameters) for e in entries]


def gravity_pull(gravity: AxisGravity | None, position: FloatArray) -> FloatArray:
    """Torque (force) of gravity on the axis: against the torque that holds it; shape as given."""
    if gravity is None:
        return np.zeros_like(position)
    constant = gravity.force_n + gravity.constant_nm
    held = constant + gravity.torque_nm * np.sin(position - gravity.zero_rad)
    pull: FloatArray = -held
    return pull


class AxisChain:
    """One axis: gear and encoder, no linkage; `load` is what pulls at it from outside.

    With a drive stiffness (N m/rad or N/m) the position yields under gravity and load by itself.
    """

    def __init__(
        self,
        motion: Motion = "rotary",
        gravity: AxisGravity | None = None,
        drive_stiffness: float | None = None,
        rad_per_step: float = 0.0,
        known: Sequence[EffectEntry] = (),
    ):
        self.kinds = command_effects(motion)
        self.gravity, self.drive_stiffness = gravity, drive_stiffness
        self.rad_per_step = rad_per_step
        self._known = tuple(known)
        entries_of(self._known, self.kinds)

    def pull(self, commands: Commands, load: FloatArray | None = None) -> FloatArray:
        """What pulls at the axis along its commanded motion, shape (n, 1)."""
        pull = gravity_pull(self.gravity, commands.angles_rad)
        return pull if load is None else pull + load[:, None]

    def simulate(
        self, commands: Commands, effects: Iterable[Active] = (), pull: FloatArray | None = None
    ) -> FloatArray:
        """What the encoder reads, shape (n,)."""
        pull = self.pull(commands) if pull is None else pull
        flow = Flow(
            t_s=commands.t_s,
            fresh=commands.fresh,
            start_s=float(commands.t_s[0]),
            angles_rad=np.array(commands.angles_rad),
            load_of=lambda: Load(pull, np.zeros_like(pull)),
            rad_per_step=self.rad_per_step,
            smooth=True,
        )
        if self.drive_stiffness is not None:
            flow.angles_rad += pull / self.drive_stiffness
        active = [*entries_of(self._known, self.kinds), *effects]
        for port in PORTS:
            for effect in at(active, port):
                effect.act(flow)
        flow.measured_rad = flow.angles_rad.copy()
        for effect in at(active, Port.ENCODER):
            effect.act(flow)
        return flow.measured_rad[:, 0]


class SensorChain:
    """The last links of the delta's chain, for one sensor."""

    def __init__(self, known: Sequence[EffectEntry] = ()):
        self.kinds = sensor_effects()
        self._known = tuple(known)
        entries_of(self._known, self.kinds)

    def simulate(
        self,
        t_s: FloatArray,
        distance_m: FloatArray,
        fresh: BoolArray,
        effects: Iterable[Active] = (),
    ) -> FloatArray:
        """What the sensor reports, shape (n,)."""
        nothing = np.zeros((len(t_s), 1))
        flow = Flow(t_s, fresh, float(t_s[0]), nothing, lambda: Load(nothing, nothing))
        flow.ranges_m = np.array(distance_m)[:, None]
        active = [*entries_of(self._known, self.kinds), *effects]
        for effect in at(active, Port.SENSOR):
            effect.act(flow)
        flow.measured_rad = flow.ranges_m
        for effect in at(active, Port.ENCODER):
            effect.act(flow)
        return flow.measured_rad[:, 0]


@dataclass(frozen=True, slots=True, eq=False)
class Driven:
    """Effort and measured motion over time; arrays of shape (n,)."""

    t_s: FloatArray
    fresh: BoolArray
    effort: FloatArray
    position: FloatArray
    velocity: FloatArray
    direction: FloatArray
    """Direction of motion, -1 to 1: friction changes sign over an uncertain range of speed."""
    at_rest: BoolArray
    load: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Force:
    """What acts on the mass (n,) [N m or N], and how much mass there is [kg m2 or kg]."""

    force: FloatArray
    inertia: float


class EffortChain:
    """One axis of a known inertia, effort gain and gravity, with the effects of its file."""

    def __init__(self, robot: ServoAxis):
        self.robot = robot
        self.kinds = effort_effects(robot.motion)
        self._known = entries_of(robot.effects, self.kinds)

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
            angles_rad=robot.force_per_effort * driven.effort[:, None],
            load_of=lambda: Load(load, np.zeros_like(load)),
            position=column,
            velocity=driven.velocity[:, None],
            direction=driven.direction[:, None],
            at_rest=driven.at_rest[:, None],
            inertia=robot.inertia,
        )
        for effect in at(self._known, Port.MOTOR):
            effect.act(flow)
        flow.angles_rad = flow.angles_rad + gravity_pull(robot.gravity, column) + load
        for port in (Port.GEAR, Port.ARM):
            for effect in at(self._known, port):
                effect.act(flow)
        return Force(flow.angles_rad[:, 0], flow.inertia)


__all__ = ["Driven", "EffortChain", "Force", "Motion"]
