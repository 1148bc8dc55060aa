"""The whole chain of a rotary delta, vectorised over time."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields
from functools import cache

import numpy as np

from deltactl.models.chain.active import Active, at, of_entries
from deltactl.models.chain.commands import Commands, Outputs
from deltactl.models.effects.flow import Flow, Load
from deltactl.models.effects.kind import Port
from deltactl.models.gravity import gravity_torque_nm, torque_per_kg_nm
from deltactl.models.linkage import Linkage, forward
from deltactl.models.robot import DeltaRobot, EffectEntry, FloatArray

KEPT = 4


class Assembled:
    """Forward kinematics that remembers its last few results."""

    def __init__(self) -> None:
        self._last: deque[tuple[Linkage, FloatArray, FloatArray]] = deque(maxlen=KEPT)

    def position_m(self, linkage: Linkage, angles_rad: FloatArray) -> FloatArray:
        """Platform positions (n, 3), the caller's to change; angles (n, 3), not to change."""
        for place, known in enumerate(self._last):
            if np.array_equal(known[1], angles_rad) and _same(known[0], linkage):
                del self._last[place]
                self._last.append(known)
                return known[2].copy()
        position_m = forward(linkage, angles_rad).position_m
        self._last.append((linkage, angles_rad, position_m.copy()))
        return position_m


def _same(one: Linkage, other: Linkage) -> bool:
    return one is other or all(
        np.array_equal(getattr(one, field.name), getattr(other, field.name))
        for field in fields(Linkage)
    )


ANGLE_PORTS = (Port.MOTOR, Port.GEAR, Port.ARM)


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """Commands with what follows from them and the nominal robot alone; reused between calls."""

    commands: Commands
    load: Callable[[], Load]
    """Gravity at the joints, worked out when an effect first asks for it."""
    assembled: Assembled = field(default_factory=Assembled)


class Chain:
    """One robot's chain. Effects in the robot file belong to the model and always act."""

    def __init__(self, robot: DeltaRobot):
        self.robot = robot
        self.linkage = Linkage.of(robot.geometry)
        self._known = robot.effects
        self._fields = [field.name for field in fields(Linkage)]

    @classmethod
    def delta(cls, robot: DeltaRobot) -> Chain:
        """The chain of a delta robot."""
        return cls(robot)

    def course(self, commands: Commands) -> Course:
        """What is needed of the commands in every simulation: the load at the joints."""
        return Course(commands, cache(lambda: self._load(commands.angles_rad)))

    def simulate(
        self,
        given: Commands | Course,
        effects: Iterable[Active | EffectEntry] = (),
        start_s: float | None = None,
        previous_s: float | None = None,
    ) -> Outputs:
        """Everything that happens on commands, with the effects.

        start_s: when warming up began. previous_s: time of the last sample before, when the
        commands go on from an earlier call with the same effects. Effects remember: give fresh
        ones (or entries) for a new run.
        """
        course = given if isinstance(given, Course) else self.course(given)
        commands = course.commands
        flow = self._flow(course, commands.t_s[0] if start_s is None else start_s)
        flow.previous_s = previous_s
        active = [*of_entries(self._known), *_activated(effects)]
        for port in ANGLE_PORTS:
            for effect in at(active, port):
                effect.act(flow)
        self._assemble(flow, at(active, Port.LINKAGE), course.assembled)
        true_rad = flow.angles_rad
        known = np.isfinite(flow.position_m)
        if not known.all():
            # What remembers (ringing, a stop) must not remember a robot at nowhere for ever.
            flow.position_m = standing(flow.position_m)
        for effect in at(active, Port.PLATFORM):
            effect.act(flow)
        self._sense(flow)
        for port in (Port.SENSOR, Port.CLOCK):
            for effect in at(active, port):
                effect.act(flow)
        flow.measured_rad = true_rad.copy()
        for effect in at(active, Port.ENCODER):
            effect.act(flow)
        if not known.all():
            lost = ~known.all(axis=1)
            flow.position_m[lost] = flow.ranges_m[lost] = np.nan
        return Outputs(true_rad, flow.position_m, flow.ranges_m, flow.measured_rad)

    def _flow(self, course: Course, start_s: float) -> Flow:
        commands, drive = course.commands, self.robot.drive
        return Flow(
            t_s=commands.t_s,
            fresh=commands.fresh,
            start_s=float(start_s),
            angles_rad=np.array(commands.angles_rad),
            load_of=course.load,
            rad_per_step=drive.rad_per_step if drive else 0.0,
        )

    def _assemble(self, flow: Flow, effects: Sequence[Active], assembled: Assembled) -> None:
        linkage = self.linkage
        if effects:
            flow.linkage = {name: getattr(linkage, name) for name in self._fields}
            for effect in effects:
                effect.act(flow)
            linkage = linkage.with_(**flow.linkage)
        flow.position_m = assembled.position_m(linkage, flow.angles_rad)

    def _sense(self, flow: Flow) -> None:
        sensors = self.robot.sensors
        if sensors is not None:
            flow.sensor_axes, flow.sensor_offsets_m = sensors.axes, sensors.offsets_m
        flow.ranges_m = flow.sensor_offsets_m + flow.position_m @ flow.sensor_axes.T

    def _load(self, angles_rad: FloatArray) -> Load:
        masses = self.robot.masses
        position_m = forward(self.linkage, angles_rad).position_m
        per_kg = torque_per_kg_nm(self.linkage, angles_rad, position_m)
        if masses is None:
            return Load(np.zeros_like(per_kg), np.nan_to_num(per_kg))
        torque = gravity_torque_nm(self.linkage, masses, angles_rad, position_m, per_kg_nm=per_kg)
        return Load(np.nan_to_num(torque), np.nan_to_num(per_kg))


def standing(rows: FloatArray) -> FloatArray:
    """Rows (n, k) that stay as they last were where any of their values is unknown."""
    known = np.isfinite(rows)
    if known.all():
        return rows
    lost = ~known.all(axis=1)
    if lost.all():
        return rows
    last = np.maximum.accumulate(np.where(lost, -1, np.arange(len(rows))))
    held: FloatArray = rows[np.where(last < 0, np.argmin(lost), last)]
    return held


def _activated(effects: Iterable[Active | EffectEntry]) -> list[Active]:
    active: list[Active] = []
    for effect in effects:
        active += of_entries([effect]) if isinstance(effect, EffectEntry) else [effect]
    return active


class OnlineChain:
    """Carries the operators' state from block to block: same result as one whole call."""

    def __init__(self, robot: DeltaRobot, effects: Iterable[EffectEntry] = ()):
        self._chain = Chain(robot.model_copy(update={"effects": ()}))
        self._effects: list[Active] = of_entries([*robot.effects, *effects])
        self._start_s: float | None = None
        self._previous_s = 0.0

    def advance(self, t_s: FloatArray, counts: FloatArray) -> Outputs:
        """Go on with samples at `t_s` (n,) and commanded counts (n, 3) there.

        Times must go on increasing from call to call. Raises ValueError without a drive section.
        """
        drive = self._chain.robot.drive
        if drive is None:
            raise ValueError("the robot file needs a drive section to turn counts into angles")
        commands = Commands.of_counts(t_s, counts, drive)
        if self._start_s is None:
            self._start_s = float(commands.t_s[0])
            outputs = self._chain.simulate(commands, self._effects, self._start_s)
        else:
            commands.fresh[0] = False
            outputs = self._chain.simulate(commands, self._effects, self._start_s, self._previous_s)
        self._previous_s = float(commands.t_s[-1])
        return outputs
