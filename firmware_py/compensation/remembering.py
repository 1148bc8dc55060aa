"""What to command so that arms with play, and arms that grow, go where they are meant to.

The accepted chain is inverted by iteration: simulate the commands, add what is missing to
each, again (iterative learning, Arimoto 1984, with the model in place of the plant). For play this
moves the command across the gap within a part of the way that falls with the number of rounds,
beginning at the reversal; so there is no jump, and speed and acceleration limits are kept by the
timing, which slows the path down there. What does not remember is left to the inverse kinematics:
only the difference between the chain with memory and the one without is compensated here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from deltactl.firmware_py.compensation.hanging import Hanging, Pace
from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.chain import Chain, Commands
from deltactl.models.chain.active import at, of_entries
from deltactl.models.effects import Compensated, compensated
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.joint_friction import without_swing
from deltactl.models.effects.kind import Port
from deltactl.models.linkage import Linkage, forward, inverse
from deltactl.models.robot import ARMS, EffectEntry, FloatArray

ROUNDS = 30
"""Play is taken up within a 30th of its width of the arm's way."""
APART_S = 1e-6
TAKEN_UP = 1.5
"""The way to a path begins so many widths of play before its start."""
STILL_STEPS = 2.0
"""An arm that moves by less has no direction yet."""


@dataclass(frozen=True)
class Course:
    """Angles (n, 3) [rad] commanded at times (n,) [s] since the drives were switched on."""

    t_s: FloatArray
    angles_rad: FloatArray
    pace: Pace | None = None


class Remembering:
    """The compensation for one robot; `active` where there is something to compensate."""

    def __init__(self, robot: RobotFile):
        self._robot = robot
        self._plain = robot.model_copy(update={"effects": ()})
        self._static = CalibratedInverse(robot)
        joint = compensated(Compensated.INVERSE, Compensated.AT_REVERSALS)
        at_joints = [without_swing(entry) for entry in robot.effects if entry.effect in joint]
        hangs = [Hanging.is_one(active) for active in of_entries(at_joints)]
        hanging = (entry for entry, it_is in zip(at_joints, hangs, strict=True) if it_is)
        self._hanging = [Hanging(active) for active in of_entries(hanging)]
        self._at_joints = [
            entry for entry, it_is in zip(at_joints, hangs, strict=True) if not it_is
        ]
        warming = compensated(Compensated.WARMING)
        self._growth = [entry for entry in robot.effects if entry.effect in warming]
        self._widths_rad = _widths_rad(robot.effects)

    @property
    def active(self) -> bool:
        """Whether anything is done at all."""
        return bool(self._growth) or bool(self._widths_rad.any())

    def angles_rad(self, mapped: Course, before: Course | None = None) -> FloatArray:
        """What to command instead of angles an inverse chose, same shape.

        before: what was commanded until then, for what the arms remember.
        """
        wanted = self._meant_rad(mapped)
        if self._hanging:
            wanted = wanted + self._ahead_rad(mapped.pace or Pace(mapped.t_s), wanted)
        commanded = mapped.angles_rad.copy()
        if not self._widths_rad.any():
            return commanded + wanted - self._static.achieved_rad(commanded)
        start = Course(np.empty(0), np.empty((0, ARMS))) if before is None else before
        count = len(start.t_s)
        t_s = _increasing(np.concatenate([start.t_s, mapped.t_s]))
        for _ in range(ROUNDS):
            achieved = self._achieved_rad(t_s, np.vstack([start.angles_rad, commanded]))
            commanded = commanded + wanted - achieved[count:]
        return commanded

    def before(self, mapped: Course) -> Course:
        """A short way to the start that leaves every gear pushed as its arm will move first."""
        first = mapped.angles_rad[:1]
        pushed = first - self.preload_rad(mapped.angles_rad)
        t_s = mapped.t_s[0] - np.array([2.0, 1.0])
        return Course(t_s, np.vstack([pushed, pushed]))

    def preload_rad(self, angles_rad: FloatArray) -> FloatArray:
        """How far before the start of a path (n, 3) the way to it begins, (3,) [rad].

        Arms that hang in their play are lifted: they hang for certain then, whatever the speed.
        """
        least_rad = STILL_STEPS * self._robot.drive.rad_per_step
        moved = angles_rad - angles_rad[:1]
        first = (np.abs(moved) > least_rad).argmax(axis=0)
        direction = np.sign(moved[first, np.arange(ARMS)])
        torque_nm = self._flow(np.zeros(1), angles_rad[:1]).load.torque_nm[0]
        for hanging in self._hanging:
            direction[hanging.motor] = -np.sign(torque_nm[hanging.motor])
        preload: FloatArray = TAKEN_UP * self._widths_rad * direction
        return preload

    def _meant_rad(self, mapped: Course) -> FloatArray:
        """True angles that put the platform where the mapped ones would without memory."""
        true_rad = self._static.achieved_rad(mapped.angles_rad)
        if not self._growth:
            return true_rad
        linkage = self._static.linkage
        position_m = forward(linkage, true_rad).position_m
        found = inverse(self._grown(linkage, mapped), position_m).angles_rad
        return np.where(np.isfinite(found), found, true_rad)

    def _ahead_rad(self, pace: Pace, true_rad: FloatArray) -> FloatArray:
        """What gears with play must be ahead of hanging arms by, (n, 3)."""
        pace = replace(pace, t_s=_increasing(pace.t_s))
        load, ahead = self._flow(pace.t_s, true_rad).load, np.zeros_like(true_rad)
        for hanging in self._hanging:
            motor = hanging.motor
            ahead[:, motor] += hanging.ahead_rad(pace, true_rad[:, motor], load.torque_nm[:, motor])
        return ahead

    def _grown(self, linkage: Linkage, mapped: Course) -> Linkage:
        flow = self._flow(mapped.t_s, mapped.angles_rad)
        flow.linkage = {"upper_arm_m": np.array(linkage.upper_arm_m)}
        for active in at(of_entries(self._growth), Port.LINKAGE):
            active.act(flow)
        return linkage.with_(**flow.linkage)

    def _achieved_rad(self, t_s: FloatArray, commanded_rad: FloatArray) -> FloatArray:
        """What the chain with memory makes of commands."""
        flow = self._flow(t_s, commanded_rad)
        effects = of_entries(self._at_joints)
        for port in (Port.MOTOR, Port.GEAR, Port.ARM):
            for active in at(effects, port):
                active.act(flow)
        return flow.angles_rad

    def _flow(self, t_s: FloatArray, commanded_rad: FloatArray) -> Flow:
        course = self._chain.course(Commands.of_angles(t_s, commanded_rad))
        fresh = np.zeros(len(t_s), dtype=np.bool_)
        fresh[0] = True
        return Flow(t_s, fresh, 0.0, commanded_rad.copy(), course.load)

    @cached_property
    def _chain(self) -> Chain:
        return Chain(self._plain)


def _widths_rad(effects: tuple[EffectEntry, ...]) -> FloatArray:
    """Play and wind-up of each arm, (3,) [rad]."""
    widths = np.zeros(ARMS)
    plays = compensated(Compensated.AT_REVERSALS)
    for active in of_entries(entry for entry in effects if entry.effect in plays):
        widths[active.kind.index(active.component)] += float(active.values["width"])
    return widths


def _increasing(t_s: FloatArray) -> FloatArray:
    """The same times, none before or at the one before it."""
    apart: FloatArray = np.maximum.accumulate(t_s) + APART_S * np.arange(len(t_s))
    return apart
