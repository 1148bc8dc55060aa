"""What to command so that arms with play, and arms that grow, go where they are meant to.

The accepted chain is inverted by iteration: simulate the commands, add what is missing to
each, again (iterative learning, Arimoto 1984, with the model in place of the plant). For play this
moves the command across the gap within a part of the way that falls with the number of rounds,
beginning at the reversal; so there is no jump, and speed and acceleration limits are kept by the
timing, which slows the path down there. What does not remember is left to the inverse kinematics:
only the difference between the chain with memory and the one without is compensated here.

Play in which an arm hangs: inside the play the arm falls, no faster than its drag lets it. Where it
is to move faster than it falls the motor has to push it; where it is to move slower it hangs on the
other flank. Which of the two is decided beforehand, from speeds averaged over a moment and with
hysteresis: near the speed of falling both would do, and to change is to make the gear rattle.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from deltactl.firmware_py.robot_file import RobotFile
from deltactl.models.calibrated_inverse import CalibratedInverse
from deltactl.models.chain import Chain, Commands
from deltactl.models.chain.active import Active, at, of_entries
from deltactl.models.effects import Compensated, compensated
from deltactl.models.effects.flow import Flow
from deltactl.models.effects.gear_backlash import STICKS, drag_on_teeth
from deltactl.models.effects.joint_friction import without_swing
from deltactl.models.effects.kind import Port, scalar
from deltactl.models.linkage import Linkage, forward, inverse
from deltactl.models.robot import ARMS, EffectEntry, FloatArray

AVERAGED_S = 0.1
"""To either side."""
RELUCTANCE = 0.07
"""A flank is left when the speed is beyond that of falling by this share of it."""
STILL_RADPS = 1e-5
AWAY = 0.05
"""Share of the play by which an arm may leave its path while its gear crosses the play."""
MOST_ACROSS_S = 0.4
"""The longest that a gear crosses so that it is no faster than elsewhere on the path."""


class Hanging:
    """One motor's play."""

    def __init__(self, play: Active):
        self.motor = play.kind.index(play.component)
        self._half_rad = 0.5 * scalar(play.values, "width")
        self._drag = max(scalar(play.values, "drag"), 1e-6)
        self._friction_nm = scalar(play.values, "friction")
        self._stiffness = scalar(play.values, "stiffness")

    @staticmethod
    def is_one(effect: Active) -> bool:
        """Whether an effect is play in which arms fall, and do not stick."""
        return "drag" in effect.values and scalar(effect.values, "drag") < STICKS

    def ahead_rad(
        self, t_s: FloatArray, angle_rad: FloatArray, torque_nm: FloatArray
    ) -> FloatArray:
        """What the gear must be ahead of the arm by, for angles meant at increasing times, (n,)."""
        beyond = np.maximum(np.abs(torque_nm) - self._friction_nm, 0.0)
        falls = np.sign(torque_nm) * beyond / self._drag
        late, early = t_s + AVERAGED_S, t_s - AVERAGED_S
        apart = np.minimum(late, t_s[-1]) - np.maximum(early, t_s[0])
        way = np.interp(late, t_s, angle_rad) - np.interp(early, t_s, angle_rad)
        speed = way / np.maximum(apart, 1e-9)
        yields = (torque_nm - drag_on_teeth(self._drag, speed)) / self._stiffness
        across = _across(t_s, speed, falls, 2.0 * self._half_rad)
        ahead: FloatArray = self._half_rad * across - yields
        return ahead


def _across(t_s: FloatArray, speed: FloatArray, falls: FloatArray, width_rad: float) -> FloatArray:
    """Where in the play the gear is, from -1 to 1: as `_flanks`, and on its way between them.

    It is half across when the arm is to move as fast as it falls, and leaves one flank and comes to
    the other where an arm that only fell would be `AWAY` from where it is meant to be.
    """
    flanks, fastest, faster = _flanks(speed, falls), np.abs(speed).max(), speed - falls
    short = np.append(0.0, np.cumsum(0.5 * (faster[1:] + faster[:-1]) * np.diff(t_s)))
    changes = (np.flatnonzero(np.diff(flanks)) + 1).tolist()
    ends = [0, *changes, len(flanks)]
    across, done = flanks.copy(), np.ones_like(flanks)
    for first, change, last in zip(ends, changes, ends[2:], strict=False):
        part, to = slice(first, last), flanks[change]
        off_rad = to * short[part] - (to * short[part]).min()
        middle = int(off_rad.argmin())
        spare = max(fastest - to * speed[first + middle], 1e-9)
        half_s = 0.5 * min(width_rad / spare, MOST_ACROSS_S)
        around_s = t_s[first + middle] + np.array([-half_s, half_s])
        away_rad = max(AWAY * width_rad, np.interp(around_s, t_s[part], off_rad).max())
        share = np.sqrt(np.minimum(off_rad / away_rad, 1.0))
        share[middle:] = np.maximum.accumulate(share[middle:])
        share[middle::-1] = np.maximum.accumulate(share[middle::-1])
        across[part] = np.where(np.arange(last - first) < middle, -to, to)
        done[part] = np.minimum(done[part], share)
    return across * done


def _flanks(speed: FloatArray, falls: FloatArray) -> FloatArray:
    """1 where the gear is ahead of the arm, -1 where it is behind; speeds (n,) [rad/s]."""
    faster = speed - falls
    reluctance = RELUCTANCE * np.abs(falls) + STILL_RADPS
    sure = np.where(np.abs(faster) > reluctance, np.sign(faster), 0.0)
    decided = np.flatnonzero(sure)
    if not len(decided):
        return np.where(falls > 0.0, -1.0, 1.0)
    # As before, where it is not sure; at the beginning as it will be.
    last = np.maximum.accumulate(np.where(sure != 0.0, np.arange(len(sure)), decided[0]))
    flanks: FloatArray = sure[last]
    return flanks


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
            wanted = wanted + self._ahead_rad(mapped.t_s, wanted)
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
        """How far before the start of a path (n, 3) the way to it begins, (3,) [rad]."""
        least_rad = STILL_STEPS * self._robot.drive.rad_per_step
        moved = angles_rad - angles_rad[:1]
        first = (np.abs(moved) > least_rad).argmax(axis=0)
        direction = np.sign(moved[first, np.arange(ARMS)])
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

    def _ahead_rad(self, t_s: FloatArray, true_rad: FloatArray) -> FloatArray:
        """What gears with play must be ahead of hanging arms by, (n, 3)."""
        increasing_s = _increasing(t_s)
        load, ahead = self._flow(increasing_s, true_rad).load, np.zeros_like(true_rad)
        for hanging in self._hanging:
            motor = hanging.motor
            ahead[:, motor] += hanging.ahead_rad(
                increasing_s, true_rad[:, motor], load.torque_nm[:, motor]
            )
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
